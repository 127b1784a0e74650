//! Numbers and small elements of Mitsuba's XML.

use glam::DVec3;

/// A number as Mitsuba reads it: the shortest text with all its digits.
pub(crate) fn number(v: f64) -> String {
    let v = if v.is_finite() { v } else { 0.0 };
    format!("{v:?}")
}

fn xyz(element: &str, name: &str, v: DVec3) -> String {
    format!(
        "<{element} name=\"{name}\" x=\"{}\" y=\"{}\" z=\"{}\"/>",
        number(v.x),
        number(v.y),
        number(v.z)
    )
}

/// A point.
pub(crate) fn point(name: &str, v: DVec3) -> String {
    xyz("point", name, v)
}

/// A direction.
pub(crate) fn vector(name: &str, v: DVec3) -> String {
    xyz("vector", name, v)
}

/// A colour.
pub(crate) fn rgb(name: &str, [r, g, b]: [f64; 3]) -> String {
    format!(
        "<rgb name=\"{name}\" value=\"{} {} {}\"/>",
        number(r),
        number(g),
        number(b)
    )
}

/// A matrix by its columns: three axes and the place of the origin.
pub(crate) fn matrix([x, y, z]: [DVec3; 3], origin: DVec3) -> String {
    let rows = (0..3).map(|i| [x, y, z, origin].map(|column| number(column[i])).join(" "));
    format!(
        "<matrix value=\"{} 0 0 0 1\"/>",
        rows.collect::<Vec<_>>().join(" ")
    )
}
