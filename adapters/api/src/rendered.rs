//! What a call has left to be read: frames are many, and a frame that nobody
//! needs yet is a file, not memory.

use crate::adapter::AdapterError;
use crate::layer::Window;

/// The answer to a request, a `T` for each of its shots: a [`Layer`](crate::Layer)
/// or a [`Picture`]. The call has ended; each is read when it is asked for.
pub struct Rendered<'a, T> {
    shots: usize,
    read: Box<dyn FnMut(usize) -> Result<T, AdapterError> + Send + 'a>,
}

impl<'a, T> Rendered<'a, T> {
    /// So many shots, which `read` reads, each at most once, in any order. What
    /// it owns goes with it: the folder of the call.
    pub fn new(
        shots: usize,
        read: impl FnMut(usize) -> Result<T, AdapterError> + Send + 'a,
    ) -> Self {
        Self {
            shots,
            read: Box::new(read),
        }
    }

    /// What is in memory already.
    pub fn here(all: Vec<T>) -> Self
    where
        T: Send + 'a,
    {
        let mut all: Vec<Option<T>> = all.into_iter().map(Some).collect();
        Self::new(all.len(), move |shot| {
            let one = all.get_mut(shot).and_then(Option::take);
            one.ok_or_else(|| AdapterError::BadOutput {
                program: "the renderer".into(),
                file: format!("shot {shot}").into(),
                reason: "it is missing".into(),
            })
        })
    }

    /// How many shots there are.
    pub fn shots(&self) -> usize {
        self.shots
    }

    /// Reads the answer to a shot. To be asked once for each.
    ///
    /// # Errors
    /// [`AdapterError::BadOutput`] where it is not what was asked for.
    pub fn read(&mut self, shot: usize) -> Result<T, AdapterError> {
        (self.read)(shot)
    }

    /// Reads all of them, in order.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn all(mut self) -> Result<Vec<T>, AdapterError> {
        (0..self.shots).map(|shot| self.read(shot)).collect()
    }
}

/// A window of a frame in the numbers of its file, as the renderer encodes them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Which part of the frame.
    pub window: Window,
    /// Red, green and blue of each pixel, row by row: a byte each, or two with
    /// the high one first.
    pub bytes: Vec<u8>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_given_once() {
        let mut three = Rendered::here(vec![1, 2, 3]);
        assert_eq!(three.shots(), 3);
        assert_eq!(three.read(1).unwrap(), 2);
        assert!(three.read(1).is_err() && three.read(3).is_err());
        assert_eq!(Rendered::here(vec![1, 2]).all().unwrap(), [1, 2]);
    }
}
