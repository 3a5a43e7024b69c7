//! Implementation of [`Persist`](super::Persist) by a list of fields.
//!
//! A macro, so that a forgotten field does not compile. It expands to two functions:
//!
//! | function | struct | enum |
//! |---|---|---|
//! | `layout` | hash of the type's name, and of name and layout of each field | the same with each variant and tag |
//! | `persist` | the configured fields, then the state, then the condition | tag, fields of the variant, condition |
//!
//! The name of the type in the hash is the one written in the macro, generics included.
//!
//! A variant that differs from the present one is constructed from blank values first and then read
//! into.

/// Implements [`Persist`](crate::persist::Persist) for a struct or an enum, field by field in the
/// order given.
///
/// ```text
/// persist!([generics] Type { field, field; unchanged field, field } if |this| condition);
/// persist!([generics] enum Type {
///     0 => Variant, 1 => Other(item: Item), 2 => Third { part: Part }
/// } if |this| condition);
/// ```
///
/// All fields of a struct must be listed. Those after `unchanged` are configuration: compared, not
/// overwritten. A struct without configuration, and every enum, also implements
/// [`Blank`](crate::persist::Blank). A value that violates the condition is rejected.
///
/// ```
/// use fsw_core::checkpoint::{FromWords, ToWords, transfer};
///
/// struct Counter {
///     limit: u32,
///     count: u32,
/// }
/// fsw_core::persist!([] Counter { count; unchanged limit } if |this| this.count <= this.limit);
///
/// let mut words = [0; 2];
/// transfer(&mut Counter { limit: 10, count: 7 }, &mut ToWords::new(&mut words)).unwrap();
/// let mut restored = Counter { limit: 10, count: 0 };
/// transfer(&mut restored, &mut FromWords::new(&words)).unwrap();
/// assert_eq!(restored.count, 7);
///
/// // Another configuration is rejected.
/// let mut other = Counter { limit: 20, count: 0 };
/// let rejected = transfer(&mut other, &mut FromWords::new(&words)).unwrap_err();
/// assert_eq!(rejected.place, "configuration");
/// ```
#[macro_export]
macro_rules! persist {
    ([$($generics:tt)*] enum $type:ty { $(
        $tag:literal => $variant:ident
            $(($($item:ident: $of_item:ty),+))? $({$($part:ident: $of_part:ty),+})?
    ),+ $(,)? } $(if |$this:ident| $valid:expr)?) => {
        impl<$($generics)*> $crate::persist::Persist for $type {
            fn layout() -> u32 {
                use $crate::persist as stream;
                let layout = const { stream::name(stringify!($type)) };
                $(
                    let layout = stream::mix(layout, const { stream::mix(stream::name(stringify!($variant)), $tag) });
                    $($(let layout = stream::mix(layout, <$of_item as stream::Persist>::layout());)+)?
                    $($(let layout = stream::mix(layout, <$of_part as stream::Persist>::layout());)+)?
                )+
                layout
            }

            #[inline(never)]
            fn persist(&mut self, archive: &mut $crate::persist::Archive<'_>) {
                let before: u32 = match self {
                    $(Self::$variant $(($($item),+))? $({$($part),+})? => {
                        $($(let _ = $item;)+)?
                        $($(let _ = $part;)+)?
                        $tag
                    })+
                };
                let mut tag = before;
                archive.word(&mut tag);
                if tag != before {
                    match tag {
                        $($tag => $crate::persist::replace(self, || Self::$variant
                            $(($(<$of_item as $crate::persist::Blank>::blank()),+))?
                            $({$($part: <$of_part as $crate::persist::Blank>::blank()),+})?),)+
                        _ => {
                            *self = <Self as $crate::persist::Blank>::blank();
                            return archive.refuse(stringify!($type));
                        }
                    }
                }
                match self {
                    $(Self::$variant $(($($item),+))? $({$($part),+})? => {
                        $($($crate::persist::Persist::persist($item, archive);)+)?
                        $($($crate::persist::Persist::persist($part, archive);)+)?
                    })+
                }
                $(
                    let $this = &*self;
                    let is_valid: bool = $valid;
                    if !is_valid {
                        archive.refuse(stringify!($type));
                    }
                )?
            }
        }

        impl<$($generics)*> $crate::persist::Blank for $type {
            fn blank() -> Self {
                $crate::persist!(@first $(
                    Self::$variant
                        $(($(<$of_item as $crate::persist::Blank>::blank()),+))?
                        $({$($part: <$of_part as $crate::persist::Blank>::blank()),+})?
                );+)
            }
        }
    };
    (@unchanged $archive:ident) => {};
    (@unchanged $archive:ident $($configured:ident)+) => {
        let before = $archive.set_configuration(true);
        $($crate::persist::Persist::persist($configured, $archive);)+
        $archive.set_configuration(before);
    };
    (@first $first:expr $(; $other:expr)*) => { $first };
    ([$($generics:tt)*] $type:ty { $($field:ident),+ $(,)? } $(if |$this:ident| $valid:expr)?) => {
        $crate::persist!(
            @fields [$($generics)*] $type { $($field),+; } $(if |$this| $valid)?
        );

        impl<$($generics)*> $crate::persist::Blank for $type {
            fn blank() -> Self {
                Self { $($field: $crate::persist::Blank::blank()),+ }
            }
        }
    };
    ([$($generics:tt)*] $type:ty {
        $($field:ident),+; unchanged $($configured:ident),+ $(,)?
    } $(if |$this:ident| $valid:expr)?) => {
        $crate::persist!(
            @fields [$($generics)*] $type { $($field),+; $($configured),+ } $(if |$this| $valid)?
        );
    };
    (@fields [$($generics:tt)*] $type:ty {
        $($field:ident),+; $($configured:ident),*
    } $(if |$this:ident| $valid:expr)?) => {
        impl<$($generics)*> $crate::persist::Persist for $type {
            fn layout() -> u32 {
                use $crate::persist as stream;
                let layout = const { stream::name(stringify!($type)) };
                $(
                    let layout =
                        stream::mix(layout, const { !stream::name(stringify!($configured)) });
                    let layout = stream::mix(layout, stream::layout_of(|this: &Self| &this.$configured));
                )*
                $(
                    let layout = stream::mix(layout, const { stream::name(stringify!($field)) });
                    let layout = stream::mix(layout, stream::layout_of(|this: &Self| &this.$field));
                )+
                layout
            }

            #[inline(never)]
            fn persist(&mut self, archive: &mut $crate::persist::Archive<'_>) {
                // Without `..`: a field that is not listed does not compile.
                let Self { $($configured,)* $($field),+ } = self;
                $crate::persist!(@unchanged archive $($configured)*);
                $($crate::persist::Persist::persist($field, archive);)+
                $(
                    let $this = &*self;
                    let is_valid: bool = $valid;
                    if !is_valid {
                        archive.refuse(stringify!($type));
                    }
                )?
            }
        }
    };
}
