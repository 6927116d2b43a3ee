use std::fmt::Display;
use std::io::{self, Write};
use std::process::ExitCode;

use umbrage::{output, scene};

use crate::feature::Feature;

/// Writes a line to standard error, and ignores errors there.
pub(crate) fn say(line: impl Display) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// The reason why the command failed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The flags, the scene or a file that they name is wrong: exit code 2.
    Input {
        /// The fault.
        message: String,
        /// The remedy, if known.
        hint: Option<String>,
    },
    /// Rendering or writing failed: exit code 1.
    Work(String),
    /// The reader of standard output has closed it, which isn't an error: exit code 0.
    Unread,
}

impl Failure {
    pub(crate) fn input(message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::Input { message: message.into(), hint: Some(hint.into()) }
    }

    /// The command lacks the requested optional part.
    pub(crate) fn without(feature: Feature) -> Self {
        Self::input(feature.lack(), feature.remedy())
    }

    /// A GPU was named together with the CPU engine.
    pub(crate) fn gpu_named_for_cpu() -> Self {
        Self::input("--device names a GPU, but the CPU renders", "add `--engine gpu`")
    }

    /// The fault, without a hint.
    #[cfg(feature = "gpu")]
    pub(crate) fn message(&self) -> &str {
        match self {
            Self::Input { message, .. } | Self::Work(message) => message,
            Self::Unread => "",
        }
    }

    /// Prints the failure and returns the exit code.
    pub(crate) fn report(self) -> ExitCode {
        match self {
            Self::Input { message, hint } => {
                say(format_args!("error: {message}"));
                if let Some(hint) = hint {
                    say(format_args!("hint: {hint}"));
                }
                ExitCode::from(2)
            }
            Self::Work(message) => {
                say(format_args!("error: {message}"));
                ExitCode::FAILURE
            }
            Self::Unread => ExitCode::SUCCESS,
        }
    }
}

impl From<scene::Error> for Failure {
    fn from(error: scene::Error) -> Self {
        if matches!(error, scene::Error::TextureFile(_)) {
            return Self::Work(error.to_string());
        }
        let missing = matches!(&error, scene::Error::Read { source, .. } if source.kind() == io::ErrorKind::NotFound);
        let address = "a scene is a file, a folder of numbered files or `demo:NAME`; `umbrage info` lists the demos";
        let message = error.to_string();
        let hint = missing.then(|| address.to_owned()).or_else(|| Feature::named_in(&message).map(Feature::remedy));
        Self::Input { message, hint }
    }
}

impl From<umbrage::Error> for Failure {
    fn from(error: umbrage::Error) -> Self {
        match error {
            umbrage::Error::Scene(error) => error.into(),
            error if error.is_of_settings() => Self::Input { message: error.to_string(), hint: None },
            other => Self::Work(other.to_string()),
        }
    }
}

impl From<output::Error> for Failure {
    fn from(error: output::Error) -> Self {
        match error {
            error if error.is_broken_pipe() => Self::Unread,
            output::Error::Unsuitable { .. } => Self::Input { message: error.to_string(), hint: None },
            other => Self::Work(other.to_string()),
        }
    }
}

/// Writing to standard output failed.
impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::Unread,
            _ => Self::Work(format!("standard output: {error}")),
        }
    }
}
