use std::io::{self, Write};
use std::path::Path;

use clap::CommandFactory;
use clap_complete::Shell;

use crate::failure::Failure;
use crate::flags::Flags;

pub(crate) const COMPLETIONS_EXAMPLES: &str = "
  umbrage completions bash > ~/.local/share/bash-completion/completions/umbrage
      For all new shells of this user";

pub(crate) const MAN_EXAMPLES: &str = "
  umbrage man | man -l -
      The manual page, at once
  umbrage man --dir ~/.local/share/man/man1
      All pages, for `man umbrage-render`; the folder must exist";

/// Prints a completion script.
pub(crate) fn completions(shell: Shell) -> Result<(), Failure> {
    // The generator panics if its writer fails, so it writes to memory.
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Flags::command(), "umbrage", &mut script);
    Ok(io::stdout().write_all(&script)?)
}

/// Prints the manual page, or writes the pages of all commands into a folder.
pub(crate) fn man(folder: Option<&Path>) -> Result<(), Failure> {
    match folder {
        Some(folder) => clap_mangen::generate_to(Flags::command(), folder)
            .map_err(|error| Failure::Work(format!("{}: can't be written: {error}", folder.display()))),
        None => Ok(clap_mangen::Man::new(Flags::command()).render(&mut io::stdout())?),
    }
}
