use glam::DVec3;
use himmel_air::Preset;
use himmel_air::reference::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string(&a[1]).unwrap();
    let mut preset = Preset::named(&a[2]).unwrap();
    let samples: u64 = a[3].parse().unwrap();
    let flat = a.get(4).is_some_and(|s| s == "flat");
    if flat {
        preset.medium.bottom_radius_m *= 1000.0;
    }
    let every: usize = a.get(5).map_or(1, |s| s.parse().unwrap());
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).step_by(every).map(|l| l.split(',').map(|f| f.parse().unwrap()).collect()).collect();
    let tracers: Vec<(f64, Tracer<1>)> =
        [680.0, 550.0, 440.0].into_iter().map(|nm| (nm, Tracer::new(&preset.medium.sampled(&[nm])).unwrap())).collect();
    let effort = Effort { samples, target_relative_error: Some(0.003), most_samples: samples * 64, seed: 5 };
    let started = std::time::Instant::now();
    let mut out = vec![None; rows.len()];
    let mut paths = 0;
    for_each_parallel(
        rows.len(),
        |i| {
            let r = &rows[i];
            let t = &tracers.iter().find(|t| t.0 == r[4]).unwrap().1;
            let (v, f) = (r[2].to_radians(), r[3].to_radians());
            let dir = DVec3::new(v.sin() * f.cos(), v.sin() * f.sin(), v.cos());
            t.radiance(&[Source::at_zenith_angle(r[1].to_radians())], r[0], dir, &effort, i as u64).unwrap()
        },
        |i, e| {
            paths += e.samples;
            out[i] = Some(e);
            true
        },
    );
    let mut d: Vec<(f64, f64, usize)> = (0..rows.len())
        .map(|i| {
            let e = out[i].as_ref().unwrap();
            let other = rows[i].get(6).copied().unwrap_or(0.0);
            (e.value[0] / rows[i][5] - 1.0, e.standard_error[0].hypot(other) / rows[i][5], i)
        })
        .collect();
    let n = d.len() as f64;
    let report = |name: &str, d: &[(f64, f64, usize)]| {
        let n = d.len() as f64;
        if n == 0.0 {
            return;
        }
        let mean = d.iter().map(|x| x.0).sum::<f64>() / n;
        let sigma = d.iter().map(|x| x.1 * x.1).sum::<f64>().sqrt() / n;
        let chi = d.iter().map(|x| (x.0 / x.1).powi(2)).sum::<f64>() / n;
        println!(
            "{name}: {n} mean {:+.4}% ± {:.4}%  chi2/n {chi:.3} worst {:.3}%",
            100.0 * mean,
            100.0 * sigma,
            100.0 * d.iter().map(|x| x.0.abs()).fold(0.0, f64::max)
        );
    };
    println!("{} s, {:.0} paths/s", started.elapsed().as_secs_f64(), paths as f64 / started.elapsed().as_secs_f64());
    report("all", &d);
    for nm in [680.0, 550.0, 440.0] {
        let s: Vec<_> = d.iter().filter(|x| rows[x.2][4] == nm).copied().collect();
        report(&format!("{nm}"), &s);
    }
    for h in [0.0, 2000.0, 10e3, 30e3] {
        let s: Vec<_> = d.iter().filter(|x| rows[x.2][0] == h).copied().collect();
        report(&format!("h {h}"), &s);
    }
    for z in [0.0, 30.0, 60.0, 75.0, 80.0, 85.0, 90., 92., 94., 96.] {
        let s: Vec<_> = d.iter().filter(|x| rows[x.2][1] == z).copied().collect();
        report(&format!("sun {z}"), &s);
    }
    for z in [0.0, 30.0, 45., 60.0, 75., 80.0, 85., 87.0, 89., 100.0, 120.0, 150.0, 180.0] {
        let s: Vec<_> = d.iter().filter(|x| rows[x.2][2] == z).copied().collect();
        report(&format!("view {z}"), &s);
    }
    d.sort_by(|a, b| (b.0 / b.1).abs().total_cmp(&(a.0 / a.1).abs()));
    for x in d.iter().take(8) {
        println!("{:?} {:+.3}% ± {:.3}% ({:.1})", rows[x.2], 100.0 * x.0, 100.0 * x.1, x.0 / x.1);
    }
    let _ = n;
}
