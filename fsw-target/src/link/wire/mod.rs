//! Values as bytes on the line, big-endian, and a walk over them that names each.
//!
//! `record!` lists the fields of a packet once: name, type, unit, meaning. From that one list come
//! the struct, its writer, its reader, and a [`Visitor`]'s walk over it, from which the host prints
//! a packet and the tests print the table in `link.md`. So the four can't disagree.
//!
//! Nothing here panics or allocates: a writer that is full remembers it, a reader that finds too
//! little says so.

mod bytes;
mod codes;
mod field;

pub use bytes::{Reader, Unreadable, Writer};
pub use codes::Coded;
pub(crate) use codes::codes;
pub use field::{Field, Values};

/// A single value, as the host prints it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A count, a time, a number of bytes.
    Whole(u64),
    /// A physical quantity.
    Number(f32),
    /// Yes or no.
    Flag(bool),
    /// A code, by its name.
    Word(&'static str),
}

/// What there is to know of a field besides its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct About {
    /// With the unit, as in `rate_rad_s`.
    pub name: &'static str,
    /// As in `rad/s`; a dash where there is none.
    pub unit: &'static str,
    /// In a sentence.
    pub meaning: &'static str,
}

/// How a field lies on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Whether a byte comes first, 1 if there is a value, 0 if not.
    pub optional: bool,
    /// The type of each element.
    pub element: &'static str,
    /// Elements; 1 for a single value.
    pub count: usize,
    /// Bytes, the first one of an optional value included.
    pub bytes: usize,
}

impl Shape {
    const fn one(element: &'static str, bytes: usize) -> Self {
        Self { optional: false, element, count: 1, bytes }
    }

    const fn times(self, count: usize) -> Self {
        Self { count: self.count * count, bytes: self.bytes * count, ..self }
    }

    const fn perhaps(self) -> Self {
        Self { optional: true, bytes: 1 + self.bytes, ..self }
    }
}

/// Is shown each field of a record in the order of the line.
pub trait Visitor {
    /// A record begins, whose fields follow.
    fn open(&mut self, about: &About);
    /// The record that began last is over.
    fn close(&mut self);
    /// A field: its values are `None` where it has none at the moment.
    fn field(&mut self, about: &About, shape: Shape, values: Option<&[Value]>);
}

/// A field, or a whole record of them.
pub trait Wire: Sized {
    /// Its bytes.
    const BYTES: usize;
    /// Writes it.
    fn put(&self, out: &mut Writer<'_>);
    /// Reads one.
    ///
    /// # Errors
    /// [`Unreadable::TooShort`] or [`Unreadable::UnknownCode`].
    fn take(from: &mut Reader<'_>) -> Result<Self, Unreadable>;
    /// Shows it, or each of its fields in order.
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

/// The bytes of a record of `$name { field: type, unit, meaning }`, and a walk over them. With
/// `struct` before the name, the struct too.
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
                // Taken apart whole, so that a field which isn't listed doesn't compile.
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
