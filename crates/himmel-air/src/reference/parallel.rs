//! Independent pieces of work on all threads, their results in order of completion.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;

/// Does `work` for each index below `count` on all threads and hands each result to `each` on this one, as it comes;
/// `each` answers whether to go on. True if all was done. Where no threads can be made (in a browser), this one does it.
///
/// ```
/// let mut sum = 0;
/// let all = himmel_air::reference::for_each_parallel(100, |i| i * i, |_, square| { sum += square; true });
/// assert!(all && sum == 328_350);
/// ```
pub fn for_each_parallel<R: Send>(
    count: usize,
    work: impl Fn(usize) -> R + Sync,
    mut each: impl FnMut(usize, R) -> bool,
) -> bool {
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(count);
    let one_by_one = |each: &mut dyn FnMut(usize, R) -> bool| (0..count).all(|index| each(index, work(index)));
    if threads < 2 || cfg!(target_family = "wasm") {
        return one_by_one(&mut each);
    }
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..threads {
            let (sender, next, stop, work) = (sender.clone(), &next, &stop, &work);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= count || sender.send((index, work(index))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        let mut done = 0;
        // Ends when every thread has hung up.
        for (index, result) in receiver {
            done += 1;
            if !stop.load(Ordering::Relaxed) && !each(index, result) {
                stop.store(true, Ordering::Relaxed);
            }
        }
        done == count && !stop.load(Ordering::Relaxed)
    })
}
