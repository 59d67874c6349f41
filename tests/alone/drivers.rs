//! Two drivers that were written apart must agree: Mesa's lavapipe and SwiftShader (`make test-drivers` fetches the
//! second, and a validation layer three years younger than Debian's). Where the specification leaves a choice to
//! drivers, a stated bound limits the difference (docs/findings.md). These tests measure nothing of their process, so
//! that they may run beside each other.

use crate::common::check_validation;
use crate::common::folder::Folder;
use serde_json::Value;
use ssct::gpu::{DeviceQuery, Gpu};
use ssct::methods::{METHODS, Setup};
use ssct_lab::stage::Globals;
use ssct_lab::study::agreement::{self, AgreementRecord, AgreementSpec, DrawnRecord};
use ssct_scenes::{Scene, library};

const LAVAPIPE: &str = "llvmpipe";
const SWIFTSHADER: &str = "SwiftShader";

/// Odd sides, so that every level of a chain rounds.
const EXTENT: [u32; 2] = [321, 181];

/// Opens a device by its name. If it is `isotropic`, it filters textures without anisotropy.
fn open(device: &str, isotropic: bool) -> Gpu {
    let device = Some(device.to_owned());
    Gpu::open(&DeviceQuery { device, validation: true, isotropic, ..DeviceQuery::default() }).unwrap()
}

/// Returns what two devices draw for a comparison: a view of a scene by every method, at the size `EXTENT`, with rays
/// that end on the screen alone.
fn spec<'a>(scene: &'a Scene, view: &str, globals: Globals) -> AgreementSpec<'a> {
    let view = scene.view(view).unwrap();
    AgreementSpec { scene, view, globals, methods: METHODS.iter().collect(), setup: Setup::on_screen(EXTENT) }
}

/// Returns overrides that give every surface one roughness.
fn of_roughness(roughness: f32) -> Globals {
    Globals { roughness: Some(roughness), ..Globals::default() }
}

/// Returns the greatest mean FLIP error that is allowed between the drivers' images of a method on one G-buffer: first
/// for roughness 0, then for 0.1.
fn greatest_flip(method: &str) -> [f64; 2] {
    match method {
        // Its chains of half floats are blurred in many steps; lavapipe cuts off what each step stores, and SwiftShader
        // rounds it.
        "sslr" => [0.01, 0.04],
        // These methods draw the scene again, into cube maps or a mirror's image, where the devices' filters differ.
        "local-map" | "pccm" | "captures" | "planar" => [0.04, 0.04],
        // `traced` reads levels of material maps that the device makes by its own filter. With the finest level alone,
        // its images are as near as those of the methods below.
        "traced" => [0.04, 0.04],
        _ => [0.01, 0.02],
    }
}

/// Given one G-buffer, both drivers make nearly the same image by each method: FLIP stays below the method's bound.
/// Hits of mirror rays agree, and those of `unified` differ by ties alone, since a mirror's hits leave no choice to a
/// driver.
#[test]
#[ignore = "needs the driver that make test-drivers fetches"]
fn methods_make_the_same_of_one_gbuffer() {
    let [base, other] = [LAVAPIPE, SWIFTSHADER].map(|device| open(device, false));
    let mut compared = 0;
    for (scene, view) in [("rooms", "corridor"), ("museum", "exit-sign")] {
        let scene = library::scene(scene).unwrap();
        for (n, roughness) in [0.0, 0.1].into_iter().enumerate() {
            let spec = spec(&scene, view, of_roughness(roughness));
            let data = agreement::draw(&base, &spec).unwrap();
            let images = [&base, &other].map(|gpu| agreement::images(gpu, &spec, &data).unwrap());
            for record in agreement::compare(&other, base.info(), &spec, &data, [&images[0], &images[1]]) {
                let AgreementRecord { head, hits, apart, ties, rmse, flip, pixels, .. } = &record;
                let name = &head.method;
                println!("{} {view} {roughness} {name}: {hits:?} {apart:?} {ties:?} {rmse:.5} {flip:.4}", scene.name);
                assert!(*pixels > 1000 && *flip <= greatest_flip(name)[n], "{name}, {roughness}: FLIP {flip}");
                // No driver has a choice in a mirror's hits; a lobe may be traced by another ray.
                let is_mirror = roughness == 0.0;
                if let Some(agree) = hits.hit_agreement.filter(|_| is_mirror) {
                    assert!(agree >= 0.9995, "{name}: {hits:?}");
                }
                if name == "unified" && is_mirror {
                    assert_eq!(apart, ties, "hits of unified are the same but for ties");
                    assert!(apart.is_some());
                }
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 4 * METHODS.len());
    [base, other].iter().for_each(|gpu| check_validation(gpu).unwrap());
}

/// The G-buffers that the two drivers draw differ mostly by their anisotropic filters of normal maps. Without
/// anisotropy few normals differ, and without normal maps only pixels at edges of triangles do.
#[test]
#[ignore = "needs the driver that make test-drivers fetches"]
fn gbuffers_differ_by_the_filter_of_material_maps() {
    let scene = library::scene("rooms").unwrap();
    let drawn = |isotropic, globals| -> DrawnRecord {
        let gpus = [LAVAPIPE, SWIFTSHADER].map(|device| open(device, isotropic));
        let spec = spec(&scene, "corridor", globals);
        let data = gpus.each_ref().map(|gpu| agreement::draw(gpu, &spec).unwrap());
        let record = agreement::compare_drawn(gpus.each_ref(), &spec, data.each_ref(), isotropic);
        gpus.iter().for_each(|gpu| check_validation(gpu).unwrap());
        println!("{record:?}");
        record
    };
    let usual = drawn(false, of_roughness(0.0));
    let isotropic = drawn(true, of_roughness(0.0));
    let plain = drawn(true, Globals { normal_deviation: Some(0.0), ..of_roughness(0.0) });
    // Edges of triangles alone show another surface.
    assert!(plain.other_surface < 0.001 && plain.other_normal < 0.001, "{plain:?}");
    // Most differences of normals come from anisotropic filters.
    assert!(isotropic.other_normal < 0.005 && isotropic.other_color < 0.005, "{isotropic:?}");
    assert!(usual.other_normal > 10.0 * isotropic.other_normal, "{usual:?}");
}

/// The stress suite passes on SwiftShader, under the validation layers. Its hard input may rely on what lavapipe does
/// and the specification does not promise.
#[test]
#[ignore = "needs the driver that make test-drivers fetches"]
fn the_stress_suite_is_passed_on_the_second_driver() {
    let folder = Folder::new();
    let output = folder.run(&["stress", "--quick", "--validation", "--json", "--device", SWIFTSHADER]);
    let log = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{log}");
    let records: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
    let judged = records.iter().filter(|r| r["judged"] == true);
    assert!(judged.clone().count() > 100 && judged.clone().all(|r| r["pass"] == true));
    assert!(records[0]["device"]["driver"].as_str().unwrap().contains(SWIFTSHADER));
}

/// On both drivers `ssct time` records and skips the same passes of each method and finds a time above 0. A feature
/// that one driver lacks must not change which passes run, except the pass that clears triangle numbers.
#[test]
#[ignore = "needs the driver that make test-drivers fetches"]
fn both_drivers_record_and_time_the_same_passes() {
    let folder = Folder::new();
    let timed = |device: &str| -> Vec<Value> {
        let json = folder.succeed(&[
            "time",
            "--scene",
            "rooms",
            "--view",
            "corridor",
            "--size",
            "161x91",
            "--roughness",
            "0,0.1",
            "--samples",
            "3",
            "--json",
            "--validation",
            "--device",
            device,
        ]);
        serde_json::from_str(&json).unwrap()
    };
    let [by_lavapipe, by_swiftshader] = [LAVAPIPE, SWIFTSHADER].map(timed);
    // SwiftShader has no geometry shaders, so that its G-buffer does not number triangles. One more pass, called
    // "no triangle", tells this to shaders.
    let recorded = |record: &Value| -> Vec<Value> {
        record["recorded"].as_array().unwrap().iter().filter(|pass| *pass != "no triangle").cloned().collect()
    };
    let rooms = library::scene("rooms").unwrap();
    let shown = METHODS.iter().filter(|method| method.unmet_needs(&rooms).is_empty()).count();
    assert_eq!((by_lavapipe.len(), by_swiftshader.len()), (2 * shown, 2 * shown));
    for (first, second) in by_lavapipe.iter().zip(&by_swiftshader) {
        let method = &first["method"];
        assert_eq!(*method, second["method"]);
        assert_eq!((recorded(first), &first["skipped"]), (recorded(second), &second["skipped"]), "{method}");
        let [first_ms, second_ms] = [first, second].map(|record| record["total"]["median_ms"].as_f64().unwrap());
        assert!(first_ms > 0.0 && second_ms > 0.0, "{first}, {second}");
        println!("{method} {}: {first_ms} ms, {second_ms} ms", first["roughness"]);
    }
}

/// `ssct gpu-study` measures a device in seven parts and compares its images with those of the second driver. Then
/// the study is resumed and compared with its own results, as if these were another machine's: it measures nothing
/// again and finds no difference.
#[test]
#[ignore = "minutes, and needs the driver that make test-drivers fetches"]
fn a_device_is_measured_and_held_against_its_own_images() {
    let folder = Folder::new();
    let study = |more: &[&str]| {
        let arguments = ["gpu-study", "--quick", "--device", LAVAPIPE, "-o", "study"];
        let output = folder.run(&[&arguments, more].concat());
        let [pages, log] = [&output.stdout, &output.stderr].map(|s| String::from_utf8_lossy(s).into_owned());
        // The README's numbers come first. Without a terminal for a progress bar, a line names each part as it begins.
        assert_eq!(pages.lines().collect::<Vec<_>>(), ["study/readme.html", "study/index.html"], "{log}");
        assert!(log.starts_with("ssct: gpu-study, part 1 of 7: the README's numbers\n"), "{log}");
        assert!(log.lines().count() == 7 && log.contains("part 7 of 7"), "{log}");
        let records: Vec<Value> = serde_json::from_str(&folder.text("study/gpu-study.json")).unwrap();
        records
    };
    let records = study(&[]);
    let records_of = |kind: &str| records.iter().filter(|r| r["kind"] == kind).collect::<Vec<_>>();
    let times: Vec<Value> = serde_json::from_str(&folder.text("study/time.json")).unwrap();
    // The last six records are `unified` in each stage at three roughness values.
    for stages in times[times.len() - 6..].chunks_exact(2) {
        let [fragment, compute] = [&stages[0], &stages[1]];
        assert_eq!([fragment, compute].map(|time| &time["setup"]["trace_stage"]), ["fragment", "compute"]);
        assert_eq!((&fragment["recorded"], &fragment["roughness"]), (&compute["recorded"], &compute["roughness"]));
    }
    let rates = records_of("bandwidth");
    assert!(rates.len() > 4 && rates.iter().all(|r| r["gb_per_s"].as_f64().is_some_and(|v| v > 0.0)), "{rates:?}");
    // There are two views, and rays on the screen alone, on the screen before captures, and in captures.
    assert!(
        records_of("steps").iter().all(|r| r["mean"].as_f64().is_some_and(|v| v > 1.0)),
        "{:?}",
        records_of("steps")
    );
    assert_eq!(records_of("steps").len(), 2 * 3);
    assert_eq!(records_of("validation")[0]["messages"], Value::Array(Vec::new()));
    // The second driver is installed, so that its images are compared with those of the first.
    let rooms = crate::common::built_in("rooms");
    let shown = METHODS.iter().filter(|method| method.unmet_needs(&rooms).is_empty()).count();
    assert_eq!((records_of("agreement").len(), records_of("drawn").len()), (2 * shown, 3));
    assert!(times.iter().all(|r| r["noise_floor"].as_f64().is_some()), "a floor for each");
    let page = folder.text("study/index.html");
    for part in ["Table 5.8", "Every method", "Fragment and compute", "Rates", "Steps", "Validation"] {
        assert!(page.contains(part), "{part}");
    }
    // The README's numbers: hits carry over to any device.
    let readme = records_of("readme");
    assert!(readme.iter().filter(|r| r["here"].as_f64().is_some()).count() >= 9, "{readme:?}");
    let shares: Vec<_> = readme.iter().filter(|r| ["ends", "hits"].iter().any(|f| r["figure"] == *f)).collect();
    assert!(!shares.is_empty() && shares.iter().all(|r| r["verdict"] == "same" || r["views"] == 0), "{shares:?}");
    let page = folder.text("study/readme.html").replace('\u{a0}', " ");
    let names_command = |row: &str| row.contains("not comparable") && row.contains("make league");
    assert!(page.split("<tr").any(names_command), "a row names the command that measures it");
    // The study is compared with itself, as if with another machine's: nothing is measured again, and nothing differs.
    let again = study(&["--resume", "--beside", "study"]);
    let with_itself: Vec<_> =
        again.iter().filter(|r| r["kind"] == "agreement" && r["base"]["name"] == r["device"]["name"]).collect();
    let screen = METHODS.iter().filter(|m| m.is_screen_space()).count();
    assert_eq!(with_itself.len(), 2 * screen);
    for r in with_itself {
        assert_eq!((&r["rmse"], &r["flip"]), (&0.0.into(), &0.0.into()), "{r}");
    }
}
