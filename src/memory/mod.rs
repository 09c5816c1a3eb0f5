//! How much memory there is, so that what needs more is refused before it is asked for.
//!
//! An allocation that fails ends the program at once, and one that the system grants and cannot keep
//! ends with the process killed. So a reader that knows from a header how much it will hold asks here
//! first. Linux says how much there is; elsewhere only the allocation itself can be refused.

/// More memory is needed than there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{} of memory are needed, {}", megabytes(*need), left(*available))]
pub struct MemoryShortage {
    /// Bytes needed.
    pub need: u64,
    /// Bytes that this process can still get; `None` where the system refuses without saying.
    pub available: Option<u64>,
}

fn megabytes(bytes: u64) -> String {
    format!("{:.0} MB", bytes as f64 / 1e6)
}

fn left(available: Option<u64>) -> String {
    match available {
        Some(bytes) => format!("{} are available", megabytes(bytes)),
        None => "which the system refuses".to_owned(),
    }
}

/// Refuses to need more bytes than are available.
pub(crate) fn check(need: u64) -> Result<(), MemoryShortage> {
    match available() {
        Some(bytes) if bytes < need => Err(MemoryShortage {
            need,
            available: Some(bytes),
        }),
        _ => Ok(()),
    }
}

/// An empty vector with room for so many numbers.
pub(crate) fn room(count: usize) -> Result<Vec<f64>, MemoryShortage> {
    let need = (count as u64).saturating_mul(size_of::<f64>() as u64);
    check(need)?;
    let mut vector = Vec::new();
    let refused = MemoryShortage {
        need,
        available: None,
    };
    vector.try_reserve_exact(count).map_err(|_| refused)?;
    Ok(vector)
}

/// Bytes that this process can still get: what the machine has, or what the limits of the process
/// (`ulimit -v`, `ulimit -d`) leave, if that is less. `None` where the system does not say.
fn available() -> Option<u64> {
    let file = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let status = file("/proc/self/status");
    let limits = file("/proc/self/limits");
    let left = [
        ("Max address space", "VmSize:"),
        ("Max data size", "VmData:"),
    ];
    let left = left.into_iter().filter_map(|(limit, used)| {
        let limit: u64 = number_after(&limits, limit)?;
        Some(limit.saturating_sub(kilobytes(&status, used)?))
    });
    let machine = kilobytes(&file("/proc/meminfo"), "MemAvailable:");
    left.chain(machine).min()
}

fn kilobytes(text: &str, name: &str) -> Option<u64> {
    Some(number_after(text, name)? * 1024)
}

/// The number that follows a name at the start of a line; `None` if it is a word, such as `unlimited`.
fn number_after(text: &str, name: &str) -> Option<u64> {
    let value = text.lines().find_map(|line| line.strip_prefix(name))?;
    value.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_by_their_name() {
        let limits = "Limit  Soft Limit  Hard Limit  Units\n\
                      Max data size             unlimited  unlimited  bytes\n\
                      Max address space         307200000  unlimited  bytes\n";
        assert_eq!(number_after(limits, "Max address space"), Some(307_200_000));
        assert_eq!(number_after(limits, "Max data size"), None);
        assert_eq!(number_after(limits, "Max stack size"), None);
        assert_eq!(
            kilobytes("VmPeak:\t  9 kB\nVmSize:\t  123 kB\n", "VmSize:"),
            Some(125_952)
        );
    }

    #[test]
    fn what_does_not_fit_is_refused_with_both_numbers() {
        assert_eq!(room(1000).unwrap().capacity(), 1000);
        // More than any address space has.
        let refused = room(1 << 59).unwrap_err().to_string();
        assert!(
            refused.starts_with("4611686018427 MB of memory are needed, "),
            "{refused}"
        );
        if cfg!(target_os = "linux") {
            let bytes = available().expect("Linux says it");
            assert!(bytes > 1 << 20, "{bytes}");
            assert!(refused.ends_with(" MB are available"), "{refused}");
        }
    }
}
