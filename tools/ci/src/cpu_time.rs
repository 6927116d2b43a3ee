use std::fs;

/// Unit of Linux's process times: hundredths of a second, on every machine.
const TICKS_PER_SECOND: f64 = 100.0;

/// CPU seconds of all programs that this one has run and that have ended; `None` if the system doesn't tell. Unlike a
/// check's time on the clock, it hardly depends on other load.
pub(crate) fn of_children() -> Option<f64> {
    seconds_in(&fs::read_to_string("/proc/self/stat").ok()?)
}

/// Reads `proc_pid_stat(5)`: numbers 16 and 17 are the children's ticks in user mode and in the kernel.
fn seconds_in(stat: &str) -> Option<f64> {
    // The program's name, number 2, may hold spaces.
    let mut rest = stat.rsplit_once(')')?.1.split_whitespace().skip(13);
    let mut ticks = || rest.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / TICKS_PER_SECOND)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_are_counted() {
        let stat = "7 (a b) c) S 1 2 3 4 5 6 7 8 9 10 11 12 150 50 20 0 1";
        assert_eq!(seconds_in(stat), Some(2.0));
        assert_eq!(seconds_in("7 (a) S 1"), None);
        if cfg!(target_os = "linux") {
            assert!(of_children().is_some());
        }
    }
}
