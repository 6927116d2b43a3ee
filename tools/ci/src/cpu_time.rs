use std::fs;

/// Linux counts what processes take in hundredths of a second, on every machine.
const TICKS_PER_SECOND: f64 = 100.0;

/// Seconds that processors have spent on all programs that this one has run and that have ended; none where the system
/// doesn't say. A check's time on the clock depends on what else the machine does; this hardly does.
pub(crate) fn of_children() -> Option<f64> {
    seconds_in(&fs::read_to_string("/proc/self/stat").ok()?)
}

/// Reads `proc_pid_stat(5)`: what children took as users and in the kernel are numbers 16 and 17.
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
