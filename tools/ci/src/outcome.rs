/// How a step ended.
pub(crate) type Outcome = Result<(), NotPassed>;

/// Why a step didn't pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum NotPassed {
    /// The reason, in one or more lines.
    Failed(String),
    /// The reason: a requirement of the step isn't installed.
    Skipped(String),
}

/// A failure.
impl From<String> for NotPassed {
    fn from(why: String) -> Self {
        Self::Failed(why)
    }
}

/// The outcome of a step with a requirement that isn't installed.
pub(crate) fn skipped(why: &str) -> Outcome {
    Err(NotPassed::Skipped(why.to_owned()))
}

/// Passes if there is no complaint; otherwise fails with all of them.
pub(crate) fn of_complaints(complaints: &[String]) -> Outcome {
    if complaints.is_empty() { Ok(()) } else { Err(complaints.join("\n").into()) }
}
