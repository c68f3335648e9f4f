//! Reading size distributions as people write them: `gamma:reff=6um,veff=0.1,rmin=1um`.

use std::sync::Arc;

use super::ReadText;
use super::csv::{CsvError, Row, parse_numeric};
use super::distribution::{RADII_M, Shape, SizeDistribution};
use super::distribution_error::DistributionError;
use crate::units::parse_length_m;

pub(super) fn parse_distribution(text: &str, read: ReadText) -> Result<SizeDistribution, DistributionError> {
    let (form, rest) = text.trim().split_once(':').unwrap_or((text.trim(), ""));
    let keys = |form, accepted| Keys::parse(form, accepted, rest);
    match form.trim() {
        "mono" => parse_mono(keys("mono", "r, rmin, rmax")?),
        "gamma" => keys("gamma", "reff, veff, rmin, rmax")?
            .finish(|keys| Ok(Shape::Gamma { reff_m: keys.length_m("reff")?, veff: keys.number("veff")? })),
        "modgamma" => keys("modgamma", "alpha, gamma, rc, rmin, rmax")?.finish(|keys| {
            let (alpha, gamma) = (keys.number("alpha")?, keys.number("gamma")?);
            Ok(Shape::ModifiedGamma { alpha, gamma, rc_m: keys.length_m("rc")? })
        }),
        "lognormal" => keys("lognormal", "rg, sigma, rmin, rmax")?
            .finish(|keys| Ok(Shape::LogNormal { rg_m: keys.length_m("rg")?, sigma: keys.number("sigma")? })),
        "csv" => {
            let (file, rest) = rest.split_once(',').unwrap_or((rest, ""));
            let keys = Keys::parse("csv", "rmin, rmax", rest)?;
            keys.finish(|_| read_table(file.trim(), read))
        }
        other => Err(DistributionError::Form(other.into())),
    }
}

/// One radius; limits are accepted where they enclose it.
fn parse_mono(keys: Keys) -> Result<SizeDistribution, DistributionError> {
    let r_m = keys.length_m("r")?;
    let rmin_m = keys.optional_length_m("rmin")?.unwrap_or(r_m);
    let rmax_m = keys.optional_length_m("rmax")?.unwrap_or(r_m);
    if !(rmin_m <= r_m && r_m <= rmax_m) {
        let (rmin_um, rmax_um) = (rmin_m * 1e6, rmax_m * 1e6);
        return Err(DistributionError::Limits { of: "mono".into(), rmin_um, rmax_um });
    }
    SizeDistribution::new(Shape::Mono { r_m }, None, None)
}

fn read_table(file: &str, read: ReadText) -> Result<Shape, DistributionError> {
    let content = read(file).map_err(|reason| CsvError::Unreadable { file: file.into(), reason })?;
    let csv = parse_numeric(file, &content, 2, 2)?;
    if csv.header.as_ref().is_some_and(|header| *header != ["radius_um", "dn_dr"]) {
        return Err(DistributionError::Header(file.into()));
    }
    let (mut r_m, mut dn_dr) = (Vec::<f64>::new(), Vec::new());
    for Row { line, values } in &csv.rows {
        let (radius_m, value) = (values[0] / 1e6, values[1]);
        if !RADII_M.contains(&radius_m) || r_m.last().is_some_and(|last| *last >= radius_m) {
            return Err(DistributionError::Order { file: file.into(), line: *line });
        }
        if value < 0.0 {
            return Err(DistributionError::Negative { file: file.into(), line: *line, value });
        }
        r_m.push(radius_m);
        dn_dr.push(value);
    }
    scale(&mut dn_dr);
    Ok(Shape::Table { name: file.into(), r_m: Arc::from(r_m), dn_dr: Arc::from(dn_dr) })
}

/// Divides by the power of two below the largest value, which is exact: only ratios count, and sums cannot overflow.
fn scale(dn_dr: &mut [f64]) {
    let largest = dn_dr.iter().copied().fold(0.0, f64::max);
    if largest > 0.0 {
        let unit = largest.log2().floor().exp2();
        dn_dr.iter_mut().for_each(|value| *value /= unit);
    }
}

/// The `key=value` pairs of one distribution.
struct Keys<'a> {
    form: &'static str,
    accepted: &'static str,
    pairs: Vec<(&'a str, &'a str)>,
}

impl<'a> Keys<'a> {
    fn parse(form: &'static str, accepted: &'static str, text: &'a str) -> Result<Self, DistributionError> {
        let mut pairs: Vec<(&str, &str)> = Vec::new();
        for item in text.split(',').map(str::trim).filter(|item| !item.is_empty()) {
            let (key, value) = item.split_once('=').unwrap_or((item, ""));
            let (key, value) = (key.trim(), value.trim());
            if !accepted.split(", ").any(|name| name == key) {
                return Err(DistributionError::Key { form, key: key.into(), accepted });
            }
            if pairs.iter().any(|(name, _)| *name == key) {
                return Err(DistributionError::Twice { form, key: key.into() });
            }
            pairs.push((key, value));
        }
        Ok(Self { form, accepted, pairs })
    }

    fn find(&self, key: &str) -> Option<&'a str> {
        self.pairs.iter().find(|(name, _)| *name == key).map(|(_, value)| *value)
    }

    fn required(&self, key: &'static str) -> Result<&'a str, DistributionError> {
        self.find(key).ok_or(DistributionError::Missing { form: self.form, key, accepted: self.accepted })
    }

    fn number(&self, key: &'static str) -> Result<f64, DistributionError> {
        let text = self.required(key)?;
        text.parse().map_err(|_| DistributionError::Number { key: key.into(), text: text.into() })
    }

    fn length_m(&self, key: &'static str) -> Result<f64, DistributionError> {
        parse_length(key, self.required(key)?)
    }

    fn optional_length_m(&self, key: &'static str) -> Result<Option<f64>, DistributionError> {
        self.find(key).map(|text| parse_length(key, text)).transpose()
    }

    /// Adds the limits to a shape.
    fn finish(
        self,
        shape: impl FnOnce(&Self) -> Result<Shape, DistributionError>,
    ) -> Result<SizeDistribution, DistributionError> {
        let (r_min_m, r_max_m) = (self.optional_length_m("rmin")?, self.optional_length_m("rmax")?);
        SizeDistribution::new(shape(&self)?, r_min_m, r_max_m)
    }
}

fn parse_length(key: &str, text: &str) -> Result<f64, DistributionError> {
    parse_length_m(text).map_err(|reason| DistributionError::Length { key: key.into(), reason })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<SizeDistribution, DistributionError> {
        SizeDistribution::parse(text, &|name| match name {
            "fog.csv" => Ok("radius_um,dn_dr\n1,0\n5,2\n20,0\n".into()),
            "nm.csv" => Ok("radius_nm,dn_dr\n1,0\n5,2\n".into()),
            "volumes.csv" => Ok("radius_um,dv_dr\n1,0\n5,2\n".into()),
            "negative.csv" => Ok("1,1\n2,-1\n".into()),
            "back.csv" => Ok("1,1\n1,1\n".into()),
            "dark.csv" => Ok("1,0\n2,0\n".into()),
            _ => Err("no such file".into()),
        })
    }

    #[test]
    fn distributions_are_read_back() {
        for text in [
            "mono:r=5um",
            "gamma:reff=6um,veff=0.1",
            "modgamma:alpha=6,gamma=1,rc=4um",
            "lognormal:rg=3um,sigma=0.4",
            "csv:fog.csv",
            "gamma:reff=6um,veff=0.1,rmin=0.5um,rmax=40um",
            "csv:fog.csv,rmin=2um",
        ] {
            let distribution = parse(text).expect(text);
            assert_eq!(distribution.to_string(), text);
        }
        assert_eq!(parse(" gamma: veff = 0.1 , reff = 6000 nm "), parse("gamma:reff=6um,veff=0.1"));
        assert_eq!(parse("mono:r=5um,rmin=1um,rmax=9um"), parse("mono:r=5um"));
        assert_eq!(parse("gamma:reff=6um,veff=0.1"), Ok(SizeDistribution::default()));
    }

    #[test]
    fn errors_name_the_key_and_what_is_accepted() {
        use DistributionError::*;
        let message = |text: &str| parse(text).unwrap_err().to_string();
        assert!(message("gama:reff=6um").contains("did you mean `gamma`"));
        assert!(message("gamma:ref=6um,veff=0.1").contains("did you mean `reff`"));
        assert!(message("gamma:ref=6um").contains("reff, veff, rmin, rmax"));
        assert!(matches!(parse("gamma:reff=6um"), Err(Missing { key: "veff", .. })));
        assert!(matches!(parse("gamma:reff=6um,veff=0.1,veff=0.2"), Err(Twice { .. })));
        assert!(matches!(parse("gamma:reff=6um,veff=x"), Err(Number { .. })));
        assert!(matches!(parse("gamma:reff=6,veff=0.1"), Err(Length { .. })));
        for text in [
            "gamma:reff=0um,veff=0.1",
            "gamma:reff=6um,veff=0.5",
            "gamma:reff=6um,veff=NaN",
            "modgamma:alpha=-1,gamma=1,rc=4um",
            "lognormal:rg=3um,sigma=0",
            "mono:r=0um",
        ] {
            assert!(matches!(parse(text), Err(Range { .. })), "{text}");
        }
    }

    #[test]
    fn limits_that_hold_nothing_are_refused() {
        for text in [
            "gamma:reff=6um,veff=0.1,rmin=20um,rmax=10um",
            "gamma:reff=6um,veff=0.01,rmin=100um,rmax=200um",
            "gamma:reff=6um,veff=0.1,rmin=0um",
            "csv:fog.csv,rmin=30um",
            "csv:dark.csv",
            "mono:r=5um,rmin=6um",
        ] {
            assert!(matches!(parse(text), Err(DistributionError::Limits { .. })), "{text}: {:?}", parse(text));
        }
    }

    #[test]
    fn defective_files_are_refused() {
        assert!(matches!(parse("csv:nm.csv"), Err(DistributionError::Header(_))));
        assert!(matches!(parse("csv:volumes.csv"), Err(DistributionError::Header(_))));
        assert!(matches!(parse("csv:negative.csv"), Err(DistributionError::Negative { line: 2, .. })));
        assert!(matches!(parse("csv:back.csv"), Err(DistributionError::Order { line: 2, .. })));
        assert!(matches!(parse("csv:none.csv"), Err(DistributionError::Csv(CsvError::Unreadable { .. }))));
    }
}
