//! Optional parts of the command: each is compiled with a feature of the same name.

use crate::failure::{Failure, say};

/// An optional part of the command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Feature {
    /// The decoder of textures in AVIF.
    Avif,
    /// The engine on GPUs.
    Gpu,
    /// The papers' structures.
    Papers,
    /// The window of `umbrage view`.
    View,
}

impl Feature {
    /// The name of the cargo feature.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Avif => "avif",
            Self::Gpu => "gpu",
            Self::Papers => "papers",
            Self::View => "view",
        }
    }

    /// Whether this command has it.
    pub(crate) const fn is_there(self) -> bool {
        match self {
            Self::Avif => cfg!(feature = "avif"),
            Self::Gpu => cfg!(feature = "gpu"),
            Self::Papers => cfg!(feature = "papers"),
            Self::View => cfg!(feature = "view"),
        }
    }

    /// Fails where the command lacks it.
    pub(crate) fn check(self) -> Result<(), Failure> {
        if self.is_there() { Ok(()) } else { Err(Failure::without(self)) }
    }

    /// The message that this command lacks it.
    pub(crate) fn lack(self) -> String {
        let part = match self {
            Self::Avif => "decoder for AVIF",
            Self::Gpu => "GPU engine",
            Self::Papers => "structures of the papers",
            Self::View => "window",
        };
        format!("this `umbrage` was built without its {part}")
    }

    /// The commands that add it: one runs it in a clone of the repository, the other installs all features.
    pub(crate) fn remedy(self) -> String {
        let name = self.name();
        format!(
            "`cargo run --release --features {name} -- …` or `cargo install --path apps/cli --features full` brings it"
        )
    }

    /// The missing feature named by an error or a warning of the library.
    pub(crate) fn named_in(message: &str) -> Option<Self> {
        message.contains(umbrage::scene::AVIF_LEFT_OUT).then_some(Self::Avif)
    }

    /// Prints the remedy for a missing feature named by a scene's warnings.
    pub(crate) fn hint_at_missing(warnings: &[String]) {
        if let Some(feature) = warnings.iter().find_map(|warning| Self::named_in(warning)) {
            say(format_args!("hint: {}", feature.remedy()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_name_the_commands_that_bring_what_is_missing() {
        for (feature, part, run) in [
            (Feature::Avif, "decoder for AVIF", "`cargo run --release --features avif -- …`"),
            (Feature::Gpu, "GPU engine", "`cargo run --release --features gpu -- …`"),
            (Feature::Papers, "structures of the papers", "`cargo run --release --features papers -- …`"),
            (Feature::View, "window", "`cargo run --release --features view -- …`"),
        ] {
            let Failure::Input { message, hint: Some(hint) } = Failure::without(feature) else { panic!("{feature:?}") };
            assert_eq!(message, format!("this `umbrage` was built without its {part}"));
            assert!(hint.contains(run) && hint.contains("`cargo install --path apps/cli --features full`"), "{hint}");
            assert!(!hint.contains('\n'), "{hint}");
            assert_eq!(feature.check().is_ok(), feature.is_there());
        }
    }

    #[test]
    fn warnings_of_the_library_tell_of_features() {
        let warning = format!("a texture was left out: images[0]: {}", umbrage::scene::AVIF_LEFT_OUT);
        assert_eq!(Feature::named_in(&warning), Some(Feature::Avif));
        assert_eq!(Feature::named_in("a texture was left out: images[0]: not a usable image: AVIF: broken"), None);
    }
}
