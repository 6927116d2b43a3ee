use std::io::{self, BufRead, BufReader};
use std::process::{Command, Stdio};

/// Runs a command whose output is for the log, and shows each line of it to `see`, of whichever stream it is.
///
/// # Errors
/// Where the command fails, or can't be run.
pub(crate) fn watch(command: &mut Command, mut see: impl FnMut(&str)) -> io::Result<()> {
    let (output, input) = io::pipe()?;
    let child = command.stdout(input.try_clone()?).stderr(input).spawn();
    // The output ends when the last of those that write has ended, so this process may not be one of them.
    command.stdout(Stdio::inherit()).stderr(Stdio::inherit());
    let mut child = child?;
    for line in BufReader::new(output).split(b'\n') {
        let line = line?;
        let line = String::from_utf8_lossy(&line);
        println!("{line}");
        see(&line);
    }
    let status = child.wait()?;
    if status.success() { Ok(()) } else { Err(io::Error::other(status.to_string())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_both_streams_are_seen() {
        let shell = |script: &str| {
            let mut seen = Vec::new();
            let ended = watch(Command::new("sh").args(["-c", script]), |line| seen.push(line.to_owned()));
            seen.sort();
            (ended.is_ok(), seen)
        };
        let both = vec!["error".to_owned(), "output".to_owned()];
        assert_eq!(shell("echo output; echo error >&2"), (true, both.clone()));
        assert_eq!(shell("echo error >&2; echo output; exit 1"), (false, both));
        assert!(watch(&mut Command::new("no-such-program"), |_| {}).is_err());
    }
}
