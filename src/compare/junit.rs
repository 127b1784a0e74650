//! A comparison as JUnit XML, which continuous-integration servers read: a test
//! case for every pair and every picture without a partner.

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use super::verdict::Verdict;
use super::{Comparison, Entry};

/// The file's text. No times: the same comparison gives the same text.
///
/// # Errors
/// None that input can cause; the serializer's.
pub fn xml(comparison: &Comparison, name: &str) -> Result<String, quick_junit::SerializeError> {
    let mut suite = TestSuite::new(name);
    for entry in &comparison.entries {
        suite.add_test_case(case(entry));
    }
    if let Some(reason) = &comparison.reason {
        let status = status(comparison.verdict, std::slice::from_ref(reason));
        suite.add_test_case(TestCase::new("comparison", status));
    }
    let mut report = Report::new("decor compare");
    report.add_test_suite(suite);
    report.to_string()
}

fn case(entry: &Entry) -> TestCase {
    match entry {
        Entry::Missing { name, from } => {
            let reason = format!("missing from {}", from.letter());
            TestCase::new(name.as_str(), status(entry.verdict(), &[reason]))
        }
        Entry::Pair(pair) => {
            let mut reasons = pair.reasons.clone();
            if let Some((x, y)) = pair.moved {
                reasons.push(format!("B is A moved by ({x}, {y}) pixels"));
            }
            let mut case = TestCase::new(pair.name.as_str(), status(pair.verdict, &reasons));
            // JUnit knows no warning: what there is to say is the case's output.
            if pair.verdict == Verdict::Warning {
                case.set_system_out(format!("warning: {}", reasons.join("; ")));
            }
            case
        }
    }
}

fn status(verdict: Verdict, reasons: &[String]) -> TestCaseStatus {
    let kind = match verdict {
        Verdict::Within | Verdict::Warning => return TestCaseStatus::success(),
        Verdict::Failed => NonSuccessKind::Failure,
        Verdict::NotComparable | Verdict::Unreadable => NonSuccessKind::Error,
    };
    let mut status = TestCaseStatus::non_success(kind);
    status.set_type(verdict.words());
    status.set_message(reasons.join("; "));
    status
}
