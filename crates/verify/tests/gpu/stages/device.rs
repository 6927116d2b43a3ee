//! Devices that fail: errors, never a hang or a panic.

use std::thread;

use umbrage_gpu::primitives::Scan;
use umbrage_gpu::{Adapter, Buffer, DeviceLimits, Gpu, GpuError, Groups, Kernel, Recorder, wgpu};

use crate::common;

/// Sums the numbers 1 … 1,000 on a device.
fn sum(gpu: &Gpu) -> Result<u32, GpuError> {
    let mut values = Buffer::storage(gpu, "values");
    values.write(gpu, &(1..=1000).collect::<Vec<u32>>())?;
    let mut scan = Scan::new(gpu);
    scan.prepare(gpu, 1000)?;
    let mut recorder = Recorder::new(gpu);
    recorder.stage("scan", |pass| scan.record(gpu, pass, &values));
    recorder.submit_and_wait()?;
    let word = scan.total_word() as usize;
    Ok(scan.totals().read::<u32>(gpu, word + 1)?[word])
}

#[test]
fn a_closed_device_is_an_error() {
    let Some(gpu) = common::open(DeviceLimits::Portable) else { return };
    assert_eq!(sum(&gpu).expect("a sum"), 500_500);
    gpu.close();
    let error = sum(&gpu).expect_err("a lost device");
    assert!(matches!(error, GpuError::Lost(_) | GpuError::Rejected(_)), "{error:?}");
    // The device stays lost, and no call hangs.
    assert!(sum(&gpu).is_err());
    let another = common::gpu().expect("there was one before");
    assert_eq!(sum(&another).expect("a sum"), 500_500);
}

#[test]
fn what_is_too_large_is_named() {
    let Some(gpu) = common::gpu() else { return };
    let mut buffer = Buffer::storage(&gpu, "triangles");
    let error = buffer.reserve(&gpu, 1 << 40).expect_err("too large");
    assert_eq!(error.to_string(), "triangles needs 1099511627776 bytes in one buffer; this GPU allows 134217728");
    // Nothing was submitted to the device, which goes on.
    assert_eq!(sum(&gpu).expect("a sum"), 500_500);
}

#[test]
fn several_devices_and_threads_work_at_once() {
    let Some(first) = common::open(DeviceLimits::Portable) else { return };
    let second = Gpu::open("", DeviceLimits::Adapter).expect("there was one before");
    thread::scope(|scope| {
        let sums: Vec<_> = [&first, &second, &first, &second].map(|gpu| scope.spawn(|| sum(gpu))).into();
        for sum in sums {
            assert_eq!(sum.join().expect("no panic").expect("a sum"), 500_500);
        }
    });
}

#[test]
fn names_choose_adapters() {
    let Some(gpu) = common::gpu() else { return };
    let name = &gpu.adapter().name;
    let middle = name[name.len() / 3..].to_uppercase();
    assert!(Adapter::all().contains(gpu.adapter()));
    assert_eq!(Gpu::open(&middle, DeviceLimits::Portable).expect("the same").adapter(), gpu.adapter());
    let error = Gpu::open("no such GPU", DeviceLimits::Portable).expect_err("no such GPU").to_string();
    assert!(error.contains("no such GPU") && error.contains(name.as_str()), "{error}");
}

#[test]
fn a_device_is_shared_with_whoever_has_opened_it() {
    let Some(adapter) = common::adapter() else { return };
    let descriptor = Gpu::descriptor(&adapter, DeviceLimits::Adapter).expect("a suitable adapter");
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).expect("a device");
    let gpu = Gpu::of_device(&adapter, device.clone(), queue.clone()).expect("a suitable device");
    assert_eq!(*gpu.adapter(), Adapter::of(&adapter));
    assert_eq!(gpu.has_timestamps(), adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY));
    assert_eq!(gpu.max_binding_bytes(), Gpu::open("", DeviceLimits::Adapter).expect("a device").max_binding_bytes());
    // Meanwhile another owner polls and submits.
    thread::scope(|scope| {
        let sums = scope.spawn(|| (0..50).map(|_| sum(&gpu).expect("a sum")).collect::<Vec<_>>());
        while !sums.is_finished() {
            queue.submit([]);
            device.poll(wgpu::PollType::Poll).expect("no one has lost it");
        }
        assert_eq!(sums.join().expect("no panic"), [500_500; 50]);
    });
    // A device that is lost for one owner is lost for all.
    device.destroy();
    assert!(sum(&gpu).is_err());
}

#[test]
fn a_device_that_can_do_too_little_says_what_is_missing() {
    let Some(adapter) = common::adapter() else { return };
    let required_limits = wgpu::Limits { max_storage_buffers_per_shader_stage: 4, ..wgpu::Limits::default() };
    let descriptor = wgpu::DeviceDescriptor { required_limits, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).expect("a device");
    let is_limited = device.limits().max_storage_buffers_per_shader_stage == 4;
    assert!(is_limited, "wgpu gives more than it was asked for");
    let error = Gpu::of_device(&adapter, device, queue).expect_err("too few buffers").to_string();
    assert!(error.contains("max_storage_buffers_per_shader_stage is 4 where 8 is needed"), "{error}");
}

#[test]
fn a_device_compiles_each_kernel_once() {
    let Some(gpu) = common::open(DeviceLimits::Portable) else { return };
    let text = "override ADDED: u32 = 0u;\n\
        @group(0) @binding(0) var<storage, read_write> word: array<u32>;\n\
        @compute @workgroup_size(1) fn add() { word[0] += ADDED; }\n\
        @compute @workgroup_size(1) fn twice() { word[0] *= 2u; }\n";
    let run = |entry, added: u32| {
        let kernel = Kernel::of_text(&gpu, text, entry, &[("ADDED", added.into())]);
        let mut word = Buffer::storage(&gpu, "word");
        word.write(&gpu, &[10_u32]).expect("room");
        let mut recorder = Recorder::new(&gpu);
        recorder.stage("run", |pass| kernel.dispatch(&gpu, pass, &[&word], Groups::Flat(1)));
        recorder.submit_and_wait().expect("done");
        (word.read::<u32>(&gpu, 1).expect("read")[0], gpu.compiled_entry_points())
    };
    assert_eq!([run("add", 1), run("add", 1), run("add", 2)], [(11, 1), (11, 1), (12, 2)]);
    assert_eq!([run("twice", 2), run("add", 1), run("twice", 2)], [(20, 3), (11, 3), (20, 3)]);
    assert_eq!(common::open(DeviceLimits::Portable).expect("there was one before").compiled_entry_points(), 0);
}

#[test]
fn uploads_are_counted_apart_where_that_is_asked_for() {
    let Some(gpu) = common::open(DeviceLimits::Portable) else { return };
    let (clone, apart) = (gpu.clone(), gpu.clone().with_own_counts());
    Buffer::storage(&clone, "words").write(&clone, &[0_u32; 5]).expect("room");
    Buffer::storage(&apart, "words").write(&apart, &[0_u32; 2]).expect("room");
    assert_eq!([&gpu, &clone, &apart].map(Gpu::uploaded_bytes), [20, 20, 8]);
}
