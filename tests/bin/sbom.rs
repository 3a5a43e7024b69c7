//! Prints the software bill of materials of a flight image with the default features, CycloneDX 1.5.

fn main() -> anyhow::Result<()> {
    println!("{}", serde_json::to_string_pretty(&tests::supply::bill_of_materials()?)?);
    Ok(())
}
