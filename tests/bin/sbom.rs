//! Prints what a product is made of: the software bill of materials, CycloneDX 1.5, or the licences of its packages.

use clap::Parser;
use tests::supply::{Product, bill_of_materials, notices};

/// Software bill of materials of a product, CycloneDX 1.5.
#[derive(Parser)]
struct Arguments {
    /// The product.
    #[arg(value_enum, default_value = "flight")]
    product: Product,
    /// Texts of the licences of the packages in it, to go with a binary, instead of the bill.
    #[arg(long)]
    notices: bool,
}

fn main() -> anyhow::Result<()> {
    let Arguments { product, notices: with_notices } = Arguments::parse();
    if with_notices {
        print!("{}", notices(product)?);
    } else {
        println!("{}", serde_json::to_string_pretty(&bill_of_materials(product)?)?);
    }
    Ok(())
}
