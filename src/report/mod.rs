//! What was done, for programs: JSON.

mod summary;

pub use summary::{Clock, ObjectCounts, PeriodSummary, Summary, period_summaries};
