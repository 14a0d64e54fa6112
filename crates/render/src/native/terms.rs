//! Terms of sums on the CPU.

use std::sync::Arc;

use relight::{LayerSum, LayerTerm, LayerTerms, LightLayer};

use crate::frame::Term;

/// Layers or sums that are added up.
#[derive(Debug)]
pub(crate) enum NativeTerms {
    Layers(Vec<Term<Arc<LightLayer>>>),
    Sums(Vec<Arc<LayerSum>>),
}

impl NativeTerms {
    /// Calls `work` with the terms in the form that `relight` takes.
    pub fn with<T>(&self, work: impl FnOnce(LayerTerms) -> T) -> T {
        match self {
            Self::Layers(terms) => {
                let terms: Vec<_> = terms
                    .iter()
                    .map(|Term { layer, diffuse, specular }| LayerTerm {
                        layer,
                        diffuse: *diffuse,
                        specular: *specular,
                    })
                    .collect();
                work(LayerTerms::Layers(&terms))
            }
            Self::Sums(sums) => {
                let sums: Vec<&LayerSum> = sums.iter().map(|sum| &**sum).collect();
                work(LayerTerms::Sums(&sums))
            }
        }
    }
}
