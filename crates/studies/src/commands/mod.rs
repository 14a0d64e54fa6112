//! Arguments of each study, and output of its report.

pub mod drags;
pub mod stress;
pub mod work;
