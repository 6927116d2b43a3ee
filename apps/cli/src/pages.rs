use std::io::{self, Write};
use std::path::Path;

use clap::CommandFactory;
use clap_complete::Shell;

use crate::failure::Failure;
use crate::flags::Flags;

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
