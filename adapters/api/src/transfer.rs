//! A renderer's encoding of linear colour into 8 bits, by table.
//!
//! The renderer's own function, from linear light to one of 256 values, has a power in
//! it: 60 ms for a megapixel. But it is a staircase of 255 steps. The table holds, for each 2⁻⁷ of an octave, the
//! value at its beginning and the step in it, if there is one. Within a few units
//! in the last place of a step the renderer's function itself is asked: frames
//! are its own, bit for bit.

/// So near to a step, in units in the last place, nothing is taken for granted:
/// a power may be wrong by one, and need not rise with its argument.
const NEAR: u32 = 64;

/// Bits of a single-precision number that do not choose the entry.
const REST: u32 = 16;

/// A stretch of the numbers from 0 to 1.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// Below these bits the value is `value` …
    low: u32,
    /// … from these on one more; in between the renderer is asked.
    high: u32,
    value: u8,
}

/// The 8-bit encoding of a renderer.
#[derive(Debug)]
pub struct Transfer {
    entries: Vec<Entry>,
    /// What is brighter than 1, where that is all the same.
    above: Option<u8>,
}

impl Transfer {
    /// The table of a function from linear light to 0 … 255: 25 000 questions, 0.5 ms.
    pub fn of(encode: impl Fn(f32) -> u32) -> Self {
        let at = |bits: u32| encode(f32::from_bits(bits));
        let one = 1_f32.to_bits();
        let mut entries: Vec<Entry> = Vec::with_capacity((one >> REST) as usize + 1);
        let steps = steps(&at, one);
        let mut value = at(0);
        for bucket in 0..=one >> REST {
            let (begin, end) = (bucket << REST, (bucket + 1) << REST);
            // Steps in this stretch, or so near that it has a part in them.
            let from = steps.partition_point(|&step| step + NEAR <= begin);
            let to = steps.partition_point(|&step| step < end + NEAR);
            let (low, high) = match steps[from..to] {
                [] => (u32::MAX, u32::MAX),
                [step] if step >= begin + NEAR && step + NEAR <= end && at(step) == value + 1 => {
                    (step - NEAR, step + NEAR)
                }
                // More than an entry can tell.
                _ => (0, u32::MAX),
            };
            entries.push(Entry {
                low,
                high,
                value: value as u8,
            });
            value = at(end - 1);
        }
        let above = at(f32::MAX.to_bits());
        let above = (at(one) == above && at(f32::INFINITY.to_bits()) == above).then_some(above);
        Self {
            entries,
            above: above.map(|value| value as u8),
        }
    }

    /// One channel, as `encode` has it: the function that the table is of.
    #[inline]
    pub fn encode(&self, linear: f32, encode: impl Fn(f32) -> u32) -> u8 {
        let bits = linear.to_bits();
        if let Some(entry) = self.entries.get((bits >> REST) as usize) {
            if bits < entry.low {
                return entry.value;
            }
            if bits >= entry.high {
                return entry.value + 1;
            }
        } else if let Some(above) = self.above
            && linear > 1.0
        {
            return above;
        }
        encode(linear) as u8
    }
}

/// Where the value is another one than just before, ascending.
fn steps(at: &impl Fn(u32) -> u32, one: u32) -> Vec<u32> {
    let (mut steps, mut from, mut value) = (Vec::new(), 0, at(0));
    while at(one) != value {
        let (mut low, mut high) = (from, one);
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if at(middle) == value {
                low = middle;
            } else {
                high = middle;
            }
        }
        steps.push(high);
        (from, value) = (high, at(high));
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    /// IEC 61966-2-1, in 255 steps.
    fn srgb(linear: f32) -> u32 {
        let encoded = if linear <= 0.003_130_8 {
            linear * 12.92
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        };
        let clipped = if encoded > 0.0 { encoded.min(1.0) } else { 0.0 };
        (clipped * 255.0 + 0.5) as u32
    }

    /// Numbers around every step, a sample of all others, and what is no colour.
    fn numbers(encode: impl Fn(f32) -> u32) -> Vec<u32> {
        let at = |bits: u32| encode(f32::from_bits(bits));
        let one = 1_f32.to_bits();
        let mut numbers: Vec<u32> = (0..1 << 20).map(|k| k << 12 | k & 0xfff).collect();
        let steps = steps(&at, one);
        assert_eq!(steps.len(), 255);
        numbers.extend(steps.iter().flat_map(|bits| bits - 300..bits + 300));
        for bucket in 0..one >> REST {
            let begin = bucket << REST;
            numbers.extend([begin, begin + 1, begin + 0xffff]);
        }
        numbers.extend([0.0, -0.0, 1.0, f32::MAX, f32::INFINITY].map(f32::to_bits));
        numbers.extend([f32::NAN, -1.0, f32::NEG_INFINITY, 1e-42].map(f32::to_bits));
        numbers
    }

    #[test]
    fn the_table_says_what_the_function_says() {
        let linear = |linear: f32| (linear.clamp(0.0, 1.0) * 255.0 + 0.5) as u32;
        let functions: [fn(f32) -> u32; 2] = [srgb, linear];
        for encode in functions {
            let table = Transfer::of(encode);
            for bits in numbers(encode) {
                let linear = f32::from_bits(bits);
                let value = u32::from(table.encode(linear, encode));
                assert_eq!(value, encode(linear), "{linear:e}");
            }
        }
    }

    #[test]
    fn the_function_is_seldom_asked() {
        let entries = Transfer::of(srgb).entries;
        let asked: f64 = entries
            .iter()
            .map(|e| f64::from(e.high.saturating_sub(e.low).min(1 << REST)))
            .sum();
        let all = entries.len() as f64 * f64::from(1 << REST);
        assert!(asked / all < 1e-3, "{asked} of {all}");
    }
}
