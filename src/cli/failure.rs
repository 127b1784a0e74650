//! Exit statuses, and the error that a verb ends with.

use std::error::Error;
use std::fmt;
use std::path::Path;

use decor_api::AdapterError;
use miette::Diagnostic;

use crate::animation::AnimationError;
use crate::frames::WriteError;
use crate::job::JobError;
use crate::plan::PlanError;
use crate::render::RenderError;
use crate::stage::StageError;

/// How the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// All was done.
    Done,
    /// A verification failed its tolerance.
    Verification,
    /// The input is bad.
    BadInput,
    /// The renderer is missing, failed or timed out.
    Renderer,
    /// Something could not be written.
    Write,
    /// The arguments are wrong.
    Usage,
    /// The user stopped it.
    Stopped,
}

impl Status {
    /// The exit status.
    pub fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Verification => 1,
            Self::BadInput => 3,
            Self::Renderer => 4,
            Self::Write => 5,
            Self::Usage => 64,
            // As a shell reports a program that SIGINT ended.
            Self::Stopped => 130,
        }
    }
}

/// An error with its exit status.
#[derive(Debug)]
pub struct Failure {
    /// How the program ends.
    pub status: Status,
    inner: Box<dyn Diagnostic + Send + Sync>,
}

impl Failure {
    fn new(status: Status, inner: impl Diagnostic + Send + Sync + 'static) -> Self {
        Self {
            status,
            inner: Box::new(inner),
        }
    }

    /// The arguments do not go together.
    pub fn usage(message: impl Into<String>) -> Self {
        Self::new(
            Status::Usage,
            Words {
                message: message.into(),
                source: None,
            },
        )
    }

    /// The input is bad.
    pub fn input(error: impl Diagnostic + Send + Sync + 'static) -> Self {
        Self::new(Status::BadInput, error)
    }

    /// `path` could not be written.
    pub fn write(path: &Path, source: std::io::Error) -> Self {
        let message = format!("{} cannot be written", path.display());
        Self::new(
            Status::Write,
            Words {
                message,
                source: Some(Box::new(source)),
            },
        )
    }

    /// Stdin could not be read.
    pub fn read_stdin(source: std::io::Error) -> Self {
        let message = "stdin cannot be read".to_owned();
        Self::new(
            Status::BadInput,
            Words {
                message,
                source: Some(Box::new(source)),
            },
        )
    }

    /// Something that cannot happen did.
    pub fn internal(error: impl Error + Send + Sync + 'static) -> Self {
        let message = "decor itself failed: please report this".to_owned();
        Self::new(
            Status::Write,
            Words {
                message,
                source: Some(Box::new(error)),
            },
        )
    }
}

/// A message and its cause.
#[derive(Debug)]
struct Words {
    message: String,
    source: Option<Box<dyn Error + Send + Sync>>,
}

impl fmt::Display for Words {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl Error for Words {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.source
            .as_ref()
            .map(|source| &**source as &(dyn Error + 'static))
    }
}

impl Diagnostic for Words {}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.inner.fmt(f)
    }
}

impl Error for Failure {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.inner.source()
    }
}

impl Diagnostic for Failure {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.inner.code()
    }
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.inner.help()
    }
    fn labels(&self) -> Option<Box<dyn Iterator<Item = miette::LabeledSpan> + '_>> {
        self.inner.labels()
    }
    fn source_code(&self) -> Option<&dyn miette::SourceCode> {
        self.inner.source_code()
    }
    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        self.inner.related()
    }
}

impl From<AdapterError> for Failure {
    fn from(error: AdapterError) -> Self {
        let status = match &error {
            AdapterError::BadInput { .. } | AdapterError::Unsupported { .. } => Status::BadInput,
            AdapterError::Cancelled => Status::Stopped,
            AdapterError::Missing { .. }
            | AdapterError::Start { .. }
            | AdapterError::Failed { .. }
            | AdapterError::TimedOut { .. }
            | AdapterError::BadOutput { .. } => Status::Renderer,
            AdapterError::Io { .. } => Status::Write,
        };
        Self::of_error(status, error)
    }
}

impl Failure {
    /// An error that shows no source.
    fn of_error(status: Status, error: impl Error + Send + Sync + 'static) -> Self {
        let message = error.to_string();
        let source = error
            .source()
            .map(|s| Box::<dyn Error + Send + Sync>::from(s.to_string()));
        Self::new(status, Words { message, source })
    }
}

impl From<StageError> for Failure {
    fn from(error: StageError) -> Self {
        match error {
            StageError::Adapter(error) => error.into(),
            StageError::Object(error) => {
                let status = if error.is_cancelled() {
                    Status::Stopped
                } else if error.is_renderer() {
                    Status::Renderer
                } else {
                    Status::BadInput
                };
                Self::new(status, error)
            }
            other => Self::new(Status::BadInput, other),
        }
    }
}

impl From<PlanError> for Failure {
    fn from(error: PlanError) -> Self {
        Self::new(Status::BadInput, error)
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Self {
        Self::of_error(Status::Write, error)
    }
}

impl From<AnimationError> for Failure {
    fn from(error: AnimationError) -> Self {
        Self::of_error(Status::Write, error)
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Adapter(error) => error.into(),
            RenderError::Write(error) => error.into(),
            RenderError::Folder { .. } => Self::of_error(Status::Write, error),
        }
    }
}

impl From<JobError> for Failure {
    fn from(error: JobError) -> Self {
        match error {
            JobError::Plan(error) => error.into(),
            JobError::Render(error) => error.into(),
            JobError::Write(error) => error.into(),
        }
    }
}
