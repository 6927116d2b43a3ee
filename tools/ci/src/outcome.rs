/// How a step ended.
pub(crate) type Outcome = Result<(), NotPassed>;

/// Why a step didn't pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum NotPassed {
    /// In one line or more.
    Failed(String),
    /// Something that the step needs isn't installed.
    Skipped(String),
}

/// A failure.
impl From<String> for NotPassed {
    fn from(why: String) -> Self {
        Self::Failed(why)
    }
}

/// The outcome of a step that needs something that isn't installed.
pub(crate) fn skipped(why: &str) -> Outcome {
    Err(NotPassed::Skipped(why.to_owned()))
}

/// Passed where there is no complaint, else failed with all of them.
pub(crate) fn of_complaints(complaints: &[String]) -> Outcome {
    if complaints.is_empty() { Ok(()) } else { Err(complaints.join("\n").into()) }
}
