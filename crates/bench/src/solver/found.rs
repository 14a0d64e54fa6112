//! Result of a solver: up to three parameters.

use super::width::FloatWidth;

/// Parameters that a solver reports. NaN is kept, so that it can be counted.
#[derive(Clone, Copy, Debug)]
pub struct FoundRoots<F> {
    roots: [F; 3],
    count: usize,
}

impl<F: FloatWidth> FoundRoots<F> {
    pub fn none() -> Self {
        Self { roots: [F::zero(); 3], count: 0 }
    }

    /// Adds a parameter; at most three.
    pub fn push(&mut self, u: F) {
        self.roots[self.count] = u;
        self.count += 1;
    }

    pub fn roots(&self) -> &[F] {
        &self.roots[..self.count]
    }
}

impl<F: FloatWidth> Extend<F> for FoundRoots<F> {
    fn extend<T: IntoIterator<Item = F>>(&mut self, roots: T) {
        for u in roots {
            self.push(u);
        }
    }
}
