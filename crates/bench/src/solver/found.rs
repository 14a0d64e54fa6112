//! Result of a solver: up to three parameters.

use super::width::FloatWidth;

/// Parameters that a solver reports. NaN is kept, so that it can be counted.
#[derive(Clone, Copy, Debug)]
pub struct FoundRoots<F> {
    roots: [F; 3],
    count: usize,
}

impl<F: FloatWidth> FoundRoots<F> {
    pub fn roots(&self) -> &[F] {
        &self.roots[..self.count]
    }
}

impl<F: FloatWidth> FromIterator<F> for FoundRoots<F> {
    /// Collects at most three parameters.
    fn from_iter<T: IntoIterator<Item = F>>(roots: T) -> Self {
        let mut found = Self { roots: [F::zero(); 3], count: 0 };
        for u in roots {
            found.roots[found.count] = u;
            found.count += 1;
        }
        found
    }
}
