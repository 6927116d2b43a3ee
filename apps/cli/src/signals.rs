//! What is left to do when the command is told to end.

/// Has the partial files of this process removed when it is interrupted or told to end (SIGINT, SIGTERM), before that ends
/// it as it always did: shells say 130 or 143.
#[cfg(unix)]
pub(crate) fn clean_up_when_told_to_end() {
    use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::flag;
    use signal_hook::iterator::Signals;
    use signal_hook::low_level::emulate_default_handler;

    // A file that grows beyond what the shell allows (`ulimit -f`) is an error of the one who writes, as a full disk is.
    let _ = flag::register(SIGXFSZ, std::sync::Arc::default());
    // Where the system refuses, signals end the process at once, and its files are swept by the next one.
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else { return };
    let _ = std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        for signal in &mut signals {
            umbrage::output::remove_partial_files();
            let _ = emulate_default_handler(signal);
        }
    });
}

/// Elsewhere the next process sweeps what this one leaves behind.
#[cfg(not(unix))]
pub(crate) fn clean_up_when_told_to_end() {}
