//! How much of what is left goes into the next call, so that nobody waits for the
//! last one.

/// Two thirds of an even share of what is left, where so many run at once: about half
/// of all is in the first round, and the last ones are short.
pub fn share_of(left: usize, at_once: usize) -> usize {
    (2 * left).div_ceil(3 * at_once.max(1))
}

#[cfg(test)]
mod tests {
    use super::share_of;

    #[test]
    fn shares_shrink_to_one_and_nothing_is_left() {
        let mut left = 100;
        let mut shares = Vec::new();
        while left > 0 {
            shares.push(share_of(left, 8));
            left -= share_of(left, 8);
        }
        assert!(
            (40..60).contains(&shares[..8].iter().sum::<usize>()),
            "{shares:?}"
        );
        assert_eq!((shares[0], shares.last()), (9, Some(&1)));
        assert_eq!((share_of(9, 0), share_of(0, 8)), (6, 0));
    }
}
