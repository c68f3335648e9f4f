//! Many pieces of work in parallel, of which the ones that need much memory take turns.

use rayon::prelude::*;

/// What `work` makes of every piece, in the pieces' order. Pieces that are `large` are worked on one after the other once
/// all others are done, so that their memory is needed once and not by every thread.
///
/// # Errors
/// The first error of `work`.
pub(super) fn in_turns<P: Sync, T: Send, E: Send>(
    pieces: &[P],
    large: impl Fn(&P) -> bool + Sync,
    work: impl Fn(&P) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let small = |piece: &P| if large(piece) { Ok(None) } else { work(piece).map(Some) };
    let done: Vec<Option<T>> = pieces.par_iter().map(small).collect::<Result<_, E>>()?;
    done.into_iter().zip(pieces).map(|(done, piece)| done.map_or_else(|| work(piece), Ok)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicI32, Ordering};

    #[test]
    fn large_pieces_never_meet_and_everything_keeps_its_place() {
        let pieces: Vec<i32> = (0..200).collect();
        let at_work = AtomicI32::new(0);
        let large = |piece: &i32| piece % 3 == 0;
        let work = |piece: &i32| {
            let others = if large(piece) { at_work.fetch_add(1, Ordering::SeqCst) } else { 0 };
            std::thread::yield_now();
            if large(piece) {
                at_work.fetch_sub(1, Ordering::SeqCst);
            }
            if others == 0 { Ok(2 * piece) } else { Err(others) }
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build().unwrap();
        let doubled = pool.install(|| in_turns(&pieces, large, work));
        assert_eq!(doubled, Ok((0..200).map(|piece| 2 * piece).collect()));
    }

    #[test]
    fn errors_of_small_and_large_pieces_are_returned() {
        let fails =
            |bad: i32| in_turns(&[1, 2, 3], |piece| *piece == 2, |piece| if *piece == bad { Err(bad) } else { Ok(()) });
        assert_eq!((fails(1), fails(2), fails(0)), (Err(1), Err(2), Ok(vec![(); 3])));
    }
}
