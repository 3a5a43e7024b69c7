//! Enums as one-byte codes on the line and as words in printouts.

use super::field::{Field, Values};
use super::{Reader, Shape, Unreadable, Value, Writer};

/// Codes of an enum, one byte each: `$enum { code "word" => Variant; }`. The match is exhaustive, so
/// a variant without a code does not compile.
macro_rules! codes {
    ($name:ident { $($code:literal $word:literal => $variant:ident $(($($inner:tt)+))?;)+ }) => {
        impl $crate::link::wire::Coded for $name {
            const NAME: &'static str = stringify!($name);
            const CODES: &'static [(u8, &'static str)] = &[$(($code, $word)),+];

            fn code(self) -> (u8, &'static str) {
                match self {
                    $(Self::$variant $(($($inner)+))? => ($code, $word),)+
                }
            }

            fn of_code(code: u8) -> Option<Self> {
                match code {
                    $($code => Some(Self::$variant $(($($inner)+))?),)+
                    _ => None,
                }
            }
        }
    };
}
pub(crate) use codes;

/// An enum with a one-byte code and a word for each value.
pub trait Coded: Copy {
    /// Name of the type in tables.
    const NAME: &'static str;
    /// All codes with their words.
    const CODES: &'static [(u8, &'static str)];
    /// Code and word of this value.
    fn code(self) -> (u8, &'static str);
    /// Value of a code; `None` for an unknown code.
    fn of_code(code: u8) -> Option<Self>;
}

impl<C: Coded> Field for C {
    const SHAPE: Shape = Shape::single(C::NAME, 1);

    fn put(&self, out: &mut Writer<'_>) {
        Field::put(&self.code().0, out);
    }

    fn take(from: &mut Reader<'_>) -> Result<Self, Unreadable> {
        let code = <u8 as Field>::take(from)?;
        Self::of_code(code).ok_or(Unreadable::UnknownCode { of: C::NAME, code })
    }

    fn values(&self, values: &mut Values) -> bool {
        values.push(Value::Word(self.code().1));
        true
    }
}
