//! What the tests on random films share: the dice, the objects, the films, and
//! the bench that renders and compares them.

pub mod dice;
pub mod objects;
pub mod random_film;
pub mod trial;
