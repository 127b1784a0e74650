//! What was done and why: JSON for programs, a diagram for people.

pub mod diagram;
pub mod html;
mod machine;
mod summary;

pub use machine::Machine;
pub use summary::{Clock, ObjectCounts, PeriodSummary, Summary, period_summaries};
