//! Conversions between enums of the domain and their equals in JSON.

/// Implements `From` between two enums with the same variants and fields: from the first to the second, or with `=`
/// both ways. Variants after a semicolon have a value in the first enum, which the second leaves out.
macro_rules! same_variants {
    ($($from:ident)::+ => $($to:ident)::+ { $($variant:ident $({ $($field:ident),* })?),* $(; $($shortened:ident),*)? }) => {
        impl From<$($from)::+> for $($to)::+ {
            fn from(value: $($from)::+) -> Self {
                use $($from)::+ as Source;
                match value {
                    $(Source::$variant $({ $($field),* })? => Self::$variant $({ $($field),* })?,)*
                    $($(Source::$shortened(_) => Self::$shortened,)*)?
                }
            }
        }
    };
    ($($one:ident)::+ = $($other:ident)::+ { $($variants:tt)* }) => {
        same_variants!($($one)::+ => $($other)::+ { $($variants)* });
        same_variants!($($other)::+ => $($one)::+ { $($variants)* });
    };
}

pub(crate) use same_variants;
