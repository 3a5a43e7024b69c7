//! Records as bytes on the line, big-endian, with the name, unit and meaning of each field.
//!
//! `record!` lists the fields of a packet once: name, type, unit, meaning. From this list come the
//! struct, its writer, its reader, and the traversal by a [`Visitor`], which prints packets on the
//! host and the tables of `link.md` in the tests. All four are generated from the same list.
//!
//! Nothing here panics or allocates: an overflow is kept as a state of the [`Writer`], and a short
//! input is an error of the [`Reader`].

mod bytes;
mod codes;
mod field;

pub use bytes::{Reader, Unreadable, Writer};
pub use codes::Coded;
pub(crate) use codes::codes;
pub use field::{Field, Values};

/// One element of a field, for printing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// Count, time or number of bytes.
    Whole(u64),
    /// Physical quantity.
    Number(f32),
    /// Flag.
    Flag(bool),
    /// Word of a code.
    Word(&'static str),
}

/// Description of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct About {
    /// Name with the unit, such as `rate_rad_s`.
    pub name: &'static str,
    /// Unit, such as `rad/s`; a dash for none.
    pub unit: &'static str,
    /// Meaning, one sentence.
    pub meaning: &'static str,
}

/// Layout of a field on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// True if a presence byte comes first: 1 with a value, 0 without.
    pub optional: bool,
    /// Type of each element.
    pub element: &'static str,
    /// Number of elements; 1 for a single value.
    pub count: usize,
    /// Length in bytes, presence byte included.
    pub bytes: usize,
}

impl Shape {
    const fn single(element: &'static str, bytes: usize) -> Self {
        Self { optional: false, element, count: 1, bytes }
    }

    const fn times(self, count: usize) -> Self {
        Self { count: self.count * count, bytes: self.bytes * count, ..self }
    }

    const fn optional(self) -> Self {
        Self { optional: true, bytes: 1 + self.bytes, ..self }
    }
}

/// Visitor of the fields of a record, in the order of the line.
pub trait Visitor {
    /// Start of a record; its fields follow.
    fn open(&mut self, about: &About);
    /// End of the record opened last.
    fn close(&mut self);
    /// A field; `values` is `None` for a missing optional value.
    fn field(&mut self, about: &About, shape: Shape, values: Option<&[Value]>);
}

/// A field or a record.
pub trait Wire: Sized {
    /// Length in bytes.
    const BYTES: usize;
    /// Writes the bytes.
    fn put(&self, out: &mut Writer<'_>);
    /// Reads the bytes.
    ///
    /// # Errors
    /// [`Unreadable::TooShort`] or [`Unreadable::UnknownCode`].
    fn take(from: &mut Reader<'_>) -> Result<Self, Unreadable>;
    /// Passes the field, or each field of the record in order, to the visitor.
    fn visit(&self, about: &About, visitor: &mut dyn Visitor);
}

impl<F: Field> Wire for F {
    const BYTES: usize = F::SHAPE.bytes;

    fn put(&self, out: &mut Writer<'_>) {
        Field::put(self, out);
    }

    fn take(from: &mut Reader<'_>) -> Result<Self, Unreadable> {
        Field::take(from)
    }

    fn visit(&self, about: &About, visitor: &mut dyn Visitor) {
        let mut values = Values::NONE;
        let known = self.values(&mut values);
        visitor.field(about, F::SHAPE, known.then_some(values.all()));
    }
}

/// [`Wire`] for a record `$name { field: type, unit, meaning }`. With `struct` before the name, also
/// the struct itself.
macro_rules! record {
    ($(#[doc = $about:literal])+ struct $name:ident {
        $($(#[doc = $meaning:literal])+ $field:ident: $type:ty, $unit:literal;)+
    }) => {
        $(#[doc = $about])+
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            $($(#[doc = $meaning])+ pub $field: $type,)+
        }

        $crate::link::wire::record! {
            $name { $($(#[doc = $meaning])+ $field: $type, $unit;)+ }
        }
    };
    ($name:ident { $($(#[doc = $meaning:literal])+ $field:ident: $type:ty, $unit:literal;)+ }) => {
        impl $crate::link::wire::Wire for $name {
            const BYTES: usize = 0 $(+ <$type as $crate::link::wire::Wire>::BYTES)+;

            fn put(&self, out: &mut $crate::link::wire::Writer<'_>) {
                // The exhaustive pattern rejects an unlisted field at compile time.
                let Self { $($field),+ } = self;
                $($crate::link::wire::Wire::put($field, out);)+
            }

            fn take(
                from: &mut $crate::link::wire::Reader<'_>,
            ) -> Result<Self, $crate::link::wire::Unreadable> {
                Ok(Self { $($field: $crate::link::wire::Wire::take(from)?,)+ })
            }

            fn visit(
                &self,
                about: &$crate::link::wire::About,
                visitor: &mut dyn $crate::link::wire::Visitor,
            ) {
                visitor.open(about);
                $({
                    let (name, meaning) = (stringify!($field), concat!($($meaning),+));
                    let about = $crate::link::wire::About { name, unit: $unit, meaning };
                    $crate::link::wire::Wire::visit(&self.$field, &about, visitor);
                })+
                visitor.close();
            }
        }
    };
}
pub(crate) use record;
