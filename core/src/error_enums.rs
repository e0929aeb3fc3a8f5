//! The macro that defines the error enums.

/// Defines error enums, one for each operation. Each variant has a message, which may contain its fields.
macro_rules! errors {
    ($($(#[$about:meta])* $name:ident $(<$($of:ident),+>)? {$(
        $(#[$doc:meta])* $variant:ident $(($($value:ident: $type:ty),+))?
            $({ $($(#[$field_doc:meta])* $field:ident: $field_type:ty,)+ })? => $text:literal,
    )+})+) => {$(
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[non_exhaustive]
        pub enum $name $(<$($of),+>)? {
            $($(#[$doc])* $variant $(($($type),+))? $({ $($(#[$field_doc])* $field: $field_type),+ })?,)+
        }

        impl $(<$($of: core::fmt::Debug),+>)? core::fmt::Display for $name $(<$($of),+>)? {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                match self {
                    $(Self::$variant $(($($value),+))? $({ $($field),+ })? => write!(f, $text),)+
                }
            }
        }

        impl $(<$($of: core::fmt::Debug),+>)? core::error::Error for $name $(<$($of),+>)? {}
    )+};
}
