use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Runs a command whose output is for the log, and shows each line of it to `see`, of whichever stream it is.
///
/// # Errors
/// Where the command fails, or can't be run.
pub(crate) fn watch(command: &mut Command, see: impl FnMut(&str) + Send) -> io::Result<()> {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
    let see = Mutex::new(see);
    let copied = thread::scope(|scope| {
        let of_errors = scope.spawn(|| stderr.map_or(Ok(()), |lines| copy(lines, io::stderr(), &see)));
        let of_output = stdout.map_or(Ok(()), |lines| copy(lines, io::stdout(), &see));
        of_output.and(of_errors.join().unwrap_or_else(|_| Err(io::Error::other("a line was refused"))))
    });
    let status = child.wait()?;
    copied?;
    if status.success() { Ok(()) } else { Err(io::Error::other(status.to_string())) }
}

fn copy(from: impl Read, mut to: impl Write, see: &Mutex<impl FnMut(&str)>) -> io::Result<()> {
    for line in BufReader::new(from).split(b'\n') {
        let line = line?;
        let line = String::from_utf8_lossy(&line);
        writeln!(to, "{line}")?;
        see.lock().unwrap_or_else(PoisonError::into_inner)(&line);
    }
    Ok(())
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
