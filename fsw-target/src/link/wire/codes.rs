//! Enums as numbers on the line and words for people.

use super::field::{Field, Values};
use super::{Reader, Shape, Unreadable, Value, Writer};

/// One byte for each value of an enum: `$enum { number "word" => Variant; }`. The match has no
/// rest, so that a new variant without a number doesn't compile.
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

/// An enum whose values are numbers on the line and words for people.
pub trait Coded: Copy {
    /// Its name, as the tables have it.
    const NAME: &'static str;
    /// Every number and its word.
    const CODES: &'static [(u8, &'static str)];
    /// The number and the word of this value.
    fn code(self) -> (u8, &'static str);
    /// The value of a number.
    fn of_code(code: u8) -> Option<Self>;
}

impl<C: Coded> Field for C {
    const SHAPE: Shape = Shape::one(C::NAME, 1);

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
