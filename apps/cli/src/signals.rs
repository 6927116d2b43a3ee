//! Clean-up when the command is interrupted or terminated.

/// Removes this process's partial files on SIGINT and SIGTERM, before the signal ends it as usual: with 130 or 143
/// in shells.
#[cfg(unix)]
pub(crate) fn clean_up_when_told_to_end() {
    use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::flag;
    use signal_hook::iterator::Signals;
    use signal_hook::low_level::emulate_default_handler;

    // A file beyond the shell's limit (`ulimit -f`) becomes a write error, like a full disk.
    let _ = flag::register(SIGXFSZ, std::sync::Arc::default());
    // Without handlers, signals end the process at once, and the next one sweeps its files.
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else { return };
    let _ = std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        for signal in &mut signals {
            umbrage::output::remove_partial_files();
            let _ = emulate_default_handler(signal);
        }
    });
}

/// On other systems the next process sweeps the files that this one leaves behind.
#[cfg(not(unix))]
pub(crate) fn clean_up_when_told_to_end() {}
