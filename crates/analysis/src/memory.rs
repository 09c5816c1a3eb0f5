//! Available memory, checked before large allocations.
//!
//! A failed allocation aborts the program, and memory that the system grants but cannot provide gets the
//! process killed. A reader that gets its size from a header therefore checks here first. Linux reports
//! the available memory; on other systems only the allocation itself can fail.

/// A shortage of memory: more is needed than available.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{} of memory are needed, {}", megabytes(*need), left(*available))]
pub struct MemoryShortage {
    /// Bytes needed.
    pub need: u64,
    /// Bytes available to this process; `None` if the system refuses the allocation without a number.
    pub available: Option<u64>,
}

fn megabytes(bytes: u64) -> String {
    format!("{:.0} MB", bytes as f64 / 1e6)
}

fn left(available: Option<u64>) -> String {
    match available {
        Some(bytes) => format!("{} are available", megabytes(bytes)),
        None => "but the system refuses the allocation".to_owned(),
    }
}

/// Checks that a number of bytes is available, as far as the system reports it.
///
/// # Errors
/// If more bytes are needed than available.
pub fn check(need: u64) -> Result<(), MemoryShortage> {
    match available() {
        Some(bytes) if bytes < need => Err(MemoryShortage {
            need,
            available: Some(bytes),
        }),
        _ => Ok(()),
    }
}

/// Whether the system grants this many bytes of address space. For code that reserves more than it uses
/// and would abort the program on failure.
pub fn can_reserve(bytes: usize) -> bool {
    Vec::<u8>::new().try_reserve_exact(bytes).is_ok()
}

/// Allocates an empty vector with capacity for `count` numbers.
///
/// # Errors
/// If they exceed the available memory.
pub fn allocate(count: usize) -> Result<Vec<f64>, MemoryShortage> {
    let need = (count as u64).saturating_mul(size_of::<f64>() as u64);
    check(need)?;
    let mut vector = Vec::new();
    let shortage = MemoryShortage {
        need,
        available: None,
    };
    vector.try_reserve_exact(count).map_err(|_| shortage)?;
    Ok(vector)
}

/// Bytes available to this process: what the machine has, or what the limits of the process
/// (`ulimit -v`, `ulimit -d`) leave, whichever is less. `None` if the system does not report it.
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

/// The number after a name at the start of a line; `None` if it is a word, such as `unlimited`.
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
    fn a_shortage_is_reported_with_both_numbers() {
        assert_eq!(allocate(1000).unwrap().capacity(), 1000);
        // More than any address space.
        let shortage = allocate(1 << 59).unwrap_err().to_string();
        assert!(
            shortage.starts_with("4611686018427 MB of memory are needed, "),
            "{shortage}"
        );
        if cfg!(target_os = "linux") {
            let bytes = available().expect("Linux reports it");
            assert!(bytes > 1 << 20, "{bytes}");
            assert!(shortage.ends_with(" MB are available"), "{shortage}");
        }
    }
}
