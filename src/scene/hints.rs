//! What people look for among the settings and is elsewhere: where it is.

/// Keys by group and last part, where `*` is any, and where the thing is said.
const PLACES: &[(&[&str], &[&str], &str)] = &[
    (
        &["sun", "suns", "light", "lights"],
        &[
            "direction",
            "intensity",
            "lux",
            "illuminance",
            "color",
            "colour",
            "position",
            "rotation",
            "elevation",
            "azimuth",
        ],
        "suns are directional lights of the glTF scene: their node's rotation is the direction, their intensity is in lux",
    ),
    (
        &["camera", "cameras", "view"],
        &["*"],
        "cameras are nodes of the glTF scene, which say place, direction and field of view; `--camera NAME` takes one of them",
    ),
    (
        &["droplets", "droplet"],
        &["radius", "radius_um", "radius_m", "size", "diameter", "reff", "r"],
        "a radius is `droplets.distribution=mono:r=10um`, a mean one `gamma:reff=6um,veff=0.1`",
    ),
    (
        &["droplets", "droplet", "fog", "cloud", "extinction", "density"],
        &["extinction", "density", "extinction_per_m", "number_per_m3", "liquid_water_g_per_m3", "count", "number"],
        "how dense fog is stands in `extras.mie_cloud` of its node, mesh or material, as `extinction_per_m`, `number_per_m3` or \
         `liquid_water_g_per_m3`",
    ),
];

/// Where a thing is said that some key was thought to say; nothing where it is not known.
pub fn place_of(key: &str) -> Option<&'static str> {
    let key = key.to_lowercase();
    let (group, last) = (key.split('.').next().unwrap_or_default(), key.rsplit('.').next().unwrap_or_default());
    let is_meant =
        |groups: &[&str], parts: &[&str]| groups.contains(&group) && (parts == ["*"] || parts.contains(&last));
    PLACES.iter().find(|(groups, parts, _)| is_meant(groups, parts)).map(|(_, _, place)| *place)
}
