//! Fields: numbers, flags, codes, arrays of them, optional values.

use super::{Reader, Shape, Unreadable, Value, Writer};

/// Values of one field, one per element.
#[derive(Clone, Copy, Debug)]
pub struct Values {
    list: [Value; MOST_ELEMENTS],
    count: usize,
}

/// Largest number of elements: those of the inertia tensor.
const MOST_ELEMENTS: usize = 6;

impl Values {
    pub(super) const NONE: Self = Self { list: [Value::Flag(false); MOST_ELEMENTS], count: 0 };

    pub(super) fn push(&mut self, value: Value) {
        if let Some(place) = self.list.get_mut(self.count) {
            *place = value;
            self.count += 1;
        }
    }

    pub(super) fn all(&self) -> &[Value] {
        self.list.get(..self.count).unwrap_or_default()
    }
}

/// A field on the line.
pub trait Field: Copy {
    /// Layout on the line.
    const SHAPE: Shape;
    /// Writes the field.
    fn put(&self, out: &mut Writer<'_>);
    /// Reads the field.
    ///
    /// # Errors
    /// [`Unreadable::TooShort`] or [`Unreadable::UnknownCode`].
    fn take(from: &mut Reader<'_>) -> Result<Self, Unreadable>;
    /// Appends the field's values; returns false for a missing optional value.
    fn values(&self, values: &mut Values) -> bool;
}

macro_rules! number {
    ($($number:ident as $value:expr;)+) => {$(
        impl Field for $number {
            const SHAPE: Shape = Shape::single(stringify!($number), size_of::<$number>());

            fn put(&self, out: &mut Writer<'_>) {
                out.put(&self.to_be_bytes());
            }

            fn take(from: &mut Reader<'_>) -> Result<Self, Unreadable> {
                from.take().map(Self::from_be_bytes)
            }

            fn values(&self, values: &mut Values) -> bool {
                values.push($value(*self));
                true
            }
        }
    )+};
}

// An f32 is transmitted as its IEEE 754 bits, NaN included.
number! {
    u8 as |n| Value::Whole(u64::from(n));
    u16 as |n| Value::Whole(u64::from(n));
    u32 as |n| Value::Whole(u64::from(n));
    u64 as Value::Whole;
    f32 as Value::Number;
}

impl Field for bool {
    const SHAPE: Shape = Shape::single("bool", 1);

    fn put(&self, out: &mut Writer<'_>) {
        Field::put(&u8::from(*self), out);
    }

    fn take(from: &mut Reader<'_>) -> Result<Self, Unreadable> {
        match <u8 as Field>::take(from)? {
            0 => Ok(false),
            1 => Ok(true),
            code => Err(Unreadable::UnknownCode { of: "bool", code }),
        }
    }

    fn values(&self, values: &mut Values) -> bool {
        values.push(Value::Flag(*self));
        true
    }
}

impl<F: Field + Default, const N: usize> Field for [F; N] {
    const SHAPE: Shape = F::SHAPE.times(N);

    fn put(&self, out: &mut Writer<'_>) {
        for element in self {
            Field::put(element, out);
        }
    }

    fn take(from: &mut Reader<'_>) -> Result<Self, Unreadable> {
        let mut elements = [F::default(); N];
        for element in &mut elements {
            *element = <F as Field>::take(from)?;
        }
        Ok(elements)
    }

    fn values(&self, values: &mut Values) -> bool {
        self.iter().all(|element| element.values(values))
    }
}

/// A presence byte of 1 and the value, or a presence byte of 0 and zeros in place of the value.
impl<F: Field> Field for Option<F> {
    const SHAPE: Shape = F::SHAPE.optional();

    fn put(&self, out: &mut Writer<'_>) {
        Field::put(&self.is_some(), out);
        match self {
            Some(value) => Field::put(value, out),
            None => (0..F::SHAPE.bytes).for_each(|_| out.put(&[0])),
        }
    }

    fn take(from: &mut Reader<'_>) -> Result<Self, Unreadable> {
        if <bool as Field>::take(from)? {
            return <F as Field>::take(from).map(Some);
        }
        for _ in 0..F::SHAPE.bytes {
            from.take::<1>()?;
        }
        Ok(None)
    }

    fn values(&self, values: &mut Values) -> bool {
        self.as_ref().is_some_and(|value| value.values(values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::wire::Wire;

    #[test]
    fn full_writer_takes_no_part_of_a_value() {
        let mut buffer = [0; 4];
        let mut writer = Writer::new(&mut buffer);
        Wire::put(&0x0102_u16, &mut writer);
        Wire::put(&0x0304_0506_u32, &mut writer);
        assert_eq!(writer.finish(), None);
        assert_eq!(buffer, [1, 2, 0, 0]);
    }

    #[test]
    fn numbers_are_big_endian() {
        let mut buffer = [0; 8];
        let mut writer = Writer::new(&mut buffer);
        Wire::put(&-1.5_f32, &mut writer);
        Wire::put(&258_u16, &mut writer);
        Wire::put(&Some(true), &mut writer);
        assert_eq!(writer.finish(), Some(8));
        assert_eq!(buffer, [0xbf, 0xc0, 0, 0, 1, 2, 1, 1]);
    }

    #[test]
    fn missing_value_occupies_its_place() {
        let mut buffer = [0xff; 14];
        let mut writer = Writer::new(&mut buffer);
        Wire::put(&None::<[f32; 3]>, &mut writer);
        assert_eq!(writer.finish(), Some(13));
        let mut reader = Reader::new(buffer.get(..13).unwrap());
        assert_eq!(<Option<[f32; 3]> as Wire>::take(&mut reader), Ok(None));
        assert_eq!(reader.end(), Ok(()));
    }

    #[test]
    fn invalid_values_are_rejected() {
        assert_eq!(
            <bool as Wire>::take(&mut Reader::new(&[2])),
            Err(Unreadable::UnknownCode { of: "bool", code: 2 })
        );
        assert_eq!(<u32 as Wire>::take(&mut Reader::new(&[0; 3])), Err(Unreadable::TooShort));
        assert_eq!(Reader::new(&[0; 3]).end(), Err(Unreadable::TooLong(3)));
    }
}
