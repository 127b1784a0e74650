//! Numbers of 106 bits, as the unevaluated sum of two `f64` (Dekker, Knuth).

use std::ops::{Add, Div, Mul, Neg, Sub};

/// hi + lo, |lo| at most half a unit of hi's last place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dd(pub f64, pub f64);

fn two_sum(a: f64, b: f64) -> Dd {
    let s = a + b;
    let t = s - a;
    Dd(s, (a - (s - t)) + (b - t))
}

fn quick(a: f64, b: f64) -> Dd {
    let s = a + b;
    Dd(s, b - (s - a))
}

impl From<f64> for Dd {
    fn from(v: f64) -> Self {
        Self(v, 0.0)
    }
}

impl Add for Dd {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        let (s, t) = (two_sum(self.0, o.0), two_sum(self.1, o.1));
        let v = quick(s.0, s.1 + t.0);
        quick(v.0, v.1 + t.1)
    }
}

impl Neg for Dd {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Sub for Dd {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Mul for Dd {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let p = self.0 * o.0;
        let e = self.0.mul_add(o.0, -p);
        quick(p, e + (self.0 * o.1 + self.1 * o.0))
    }
}

impl Div for Dd {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let q = self.0 / o.0;
        let r = self - o * q.into();
        let q2 = r.0 / o.0;
        let r = r - o * q2.into();
        quick(q, q2) + (r.0 / o.0).into()
    }
}

impl Dd {
    pub const ZERO: Self = Self(0.0, 0.0);
    pub const ONE: Self = Self(1.0, 0.0);
    /// π to 106 bits.
    pub const PI: Self = Self(std::f64::consts::PI, 1.224_646_799_147_353_2e-16);

    pub fn sqrt(self) -> Self {
        if self.0 <= 0.0 {
            return Self::ZERO;
        }
        let s: Self = self.0.sqrt().into();
        let s = s + (self - s * s) / (s + s);
        s + (self - s * s) / (s + s)
    }

    pub fn value(self) -> f64 {
        self.0 + self.1
    }

    /// The sine and cosine of an angle of less than a few turns.
    pub fn sin_cos(self) -> (Self, Self) {
        // A sixteenth of the angle by its series, then doubled four times.
        let x = self * Self(1.0 / 16.0, 0.0);
        let square = x * x;
        let (mut sin, mut term) = (x, x);
        for i in 1..20 {
            let n = f64::from(2 * i);
            term = -(term * square) / Self::from(n * (n + 1.0));
            sin = sin + term;
        }
        let mut versine = Self::ZERO;
        let mut term = -Self::ONE;
        for i in 1..20 {
            let n = f64::from(2 * i);
            term = -(term * square) / Self::from(n * (n - 1.0));
            versine = versine + term;
        }
        // 1 − cos is kept, for its digits.
        for _ in 0..4 {
            let cos = Self::ONE - versine;
            versine = Self::from(2.0) * sin * sin;
            sin = Self::from(2.0) * sin * cos;
        }
        (sin, Self::ONE - versine)
    }
}

/// A vector of them.
#[derive(Clone, Copy, Debug)]
pub struct V(pub [Dd; 3]);

impl From<glam::DVec3> for V {
    fn from(v: glam::DVec3) -> Self {
        Self(v.to_array().map(Dd::from))
    }
}

impl Add for V {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self([0, 1, 2].map(|i| self.0[i] + o.0[i]))
    }
}

impl Sub for V {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self([0, 1, 2].map(|i| self.0[i] - o.0[i]))
    }
}

impl Mul<Dd> for V {
    type Output = Self;
    fn mul(self, by: Dd) -> Self {
        Self(self.0.map(|v| v * by))
    }
}

impl V {
    pub fn dot(self, o: Self) -> Dd {
        self.0[0] * o.0[0] + self.0[1] * o.0[1] + self.0[2] * o.0[2]
    }

    pub fn cross(self, o: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    pub fn length(self) -> Dd {
        self.dot(self).sqrt()
    }

    pub fn unit(self) -> Self {
        self * (Dd::ONE / self.length())
    }
}
