//! A small generator of numbers: the same films everywhere (SplitMix64).

/// The dice.
pub struct Dice(u64);

impl Dice {
    /// The dice of film `k` of a seed.
    pub fn of(seed: u64, k: u64) -> Self {
        Self(seed.wrapping_mul(1_000_003).wrapping_add(k))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From 0 to n − 1.
    pub fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    pub fn chance(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }

    /// With three digits: a film is read by people.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        ((low + unit * (high - low)) * 1000.0).round() / 1000.0
    }

    pub fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len() as u64) as usize]
    }

    pub fn rgb(&mut self, low: f64, high: f64) -> String {
        let (r, g, b) = (
            self.within(low, high),
            self.within(low, high),
            self.within(low, high),
        );
        format!("{r} {g} {b}")
    }

    /// A point of a box, or a vector, as a film writes it.
    pub fn place(&mut self, x: (f64, f64), y: (f64, f64), z: (f64, f64)) -> String {
        let (x, y, z) = (
            self.within(x.0, x.1),
            self.within(y.0, y.1),
            self.within(z.0, z.1),
        );
        format!("{x} {y} {z}")
    }
}
