//! Tests of wrong calls: null pointers, structs of wrong sizes, objects that were destroyed or are of another type, and
//! two threads on one object. Each call is refused with a sentence, and nothing else happens.

use super::program::Program;
use super::{Inputs, SIDE, assert_ok, assert_refused, last_sentence, make_reflections, sized, view};
use crate::border::SsctResult;
use crate::captures::*;
use crate::context::*;
use crate::reflections::*;
use crate::triangles::*;
use ash::vk;
use std::ptr::{dangling, dangling_mut, null, null_mut};
use std::sync::Barrier;

#[test]
fn null_pointers_are_refused_by_every_function() {
    let mut program = Program::new();
    let mut inputs = Inputs::new(&mut program, SIDE);
    let context = program.context();
    let frame = inputs.frame();
    let assert_null = |result: SsctResult, argument: &str| {
        assert_refused(result, &format!("the argument {argument} is NULL"));
    };
    unsafe {
        assert_null(ssct_context_create(null(), &mut null_mut()), "info");
        assert_null(ssct_context_create(&program.info(), null_mut()), "context");
        assert_null(ssct_context_device_info(null(), &mut sized(size_of::<SsctDeviceInfo>())), "context");
        assert_null(ssct_context_device_info(context, null_mut()), "info");
        assert_null(ssct_enable_features(null_mut(), null_mut(), null_mut()), "features");
        assert_null(ssct_reflections_create(null(), &view(SIDE), &mut null_mut()), "context");
        assert_null(ssct_reflections_create(context, null(), &mut null_mut()), "info");
        assert_null(ssct_reflections_create(context, &view(SIDE), null_mut()), "reflections");
        let parameters = SsctReflectionsInfo { parameter_count: 3, ..view(SIDE) };
        assert_null(ssct_reflections_create(context, &parameters, &mut null_mut()), "info.parameters");
        assert_null(ssct_reflections_resize(null_mut(), vk::Extent2D::default()), "reflections");
        assert_null(ssct_reflections_restart_history(null_mut()), "reflections");
        assert_null(ssct_reflections_record(null_mut(), program.commands, &frame, null_mut()), "reflections");
        assert_null(ssct_reflections_times(null_mut(), 0, &mut null(), &mut 0), "reflections");
        assert_null(ssct_capture_cubes_create(context, null(), &mut null_mut()), "info");
        assert_null(ssct_capture_cubes_record_face(null_mut(), program.commands, 0, null()), "cubes");
        assert_null(ssct_triangles_create(context, null(), 2, &mut null_mut()), "meshes");
        assert_null(ssct_triangles_create(null(), null(), 0, &mut null_mut()), "context");
        assert_null(ssct_triangles_record_upload(null_mut(), program.commands), "triangles");
        assert!(!ssct_context_has_timestamps(null()) && last_sentence().contains("context is NULL"));
        assert!(ssct_methods(null_mut()).is_null() && last_sentence().contains("count is NULL"));
        assert_eq!(ssct_context_allocated_bytes(null()), 0);
        ssct_context_trim(null());

        let reflections = make_reflections(context, &view(SIDE));
        assert_null(ssct_reflections_record(reflections, program.commands, null(), null_mut()), "frame");
        let result = ssct_reflections_record(reflections, vk::CommandBuffer::null(), &frame, null_mut());
        assert_refused(result, "the argument commands is a null handle");
        assert_null(ssct_reflections_times(reflections, 0, null_mut(), &mut 0), "times");
        assert_null(ssct_reflections_times(reflections, 0, &mut null(), null_mut()), "count");
        for (lacking, argument) in [
            (SsctFrame { camera: null(), ..frame }, "frame.camera"),
            (SsctFrame { depth: null(), ..frame }, "frame.depth"),
            (SsctFrame { normals: null(), ..frame }, "frame.normals"),
            (SsctFrame { reflectivity: null(), ..frame }, "frame.reflectivity"),
            (SsctFrame { roughness: null(), ..frame }, "frame.roughness"),
            (SsctFrame { color: null(), ..frame }, "frame.color"),
        ] {
            assert_null(ssct_reflections_record(reflections, program.commands, &lacking, null_mut()), argument);
        }
        // NULL is no object, and nothing is destroyed.
        ssct_reflections_destroy(null_mut());
        ssct_capture_cubes_destroy(null_mut());
        ssct_triangles_destroy(null_mut());
        ssct_context_destroy(null_mut());
        ssct_reflections_destroy(reflections);
        ssct_context_destroy(context);
    }
}

#[test]
fn structs_of_wrong_sizes_are_refused_by_every_function() {
    let mut program = Program::new();
    let mut inputs = Inputs::new(&mut program, SIDE);
    let context = program.context();
    unsafe {
        let reflections = make_reflections(context, &view(SIDE));
        for size in [0, 1, 7, 8, 4097, usize::MAX] {
            let assert_wrong = |result: SsctResult, name: &str| {
                assert_refused(result, &format!("is {size}; it must be sizeof({name})"));
            };
            let info = SsctContextInfo { struct_size: size, ..program.info() };
            assert_wrong(ssct_context_create(&info, &mut null_mut()), "SsctContextInfo");
            assert_wrong(ssct_context_device_info(context, &mut sized(size)), "SsctDeviceInfo");
            let info = SsctReflectionsInfo { struct_size: size, ..view(SIDE) };
            assert_wrong(ssct_reflections_create(context, &info, &mut null_mut()), "SsctReflectionsInfo");
            let frame = SsctFrame { struct_size: size, ..inputs.frame() };
            assert_wrong(ssct_reflections_record(reflections, program.commands, &frame, null_mut()), "SsctFrame");
            let frame = inputs.frame();
            let result = ssct_reflections_record(reflections, program.commands, &frame, &mut sized(size));
            assert_wrong(result, "SsctRecorded");
            assert_wrong(ssct_capture_cubes_create(context, &sized(size), &mut null_mut()), "SsctCaptureCubesInfo");
            let mut depth = *frame.depth;
            depth.struct_size = size;
            let frame = SsctFrame { depth: &depth, ..frame };
            assert_wrong(ssct_reflections_record(reflections, program.commands, &frame, null_mut()), "SsctImage");
        }
        ssct_reflections_destroy(reflections);
        ssct_context_destroy(context);
    }
}

#[test]
fn objects_that_were_destroyed_or_are_of_another_type_are_refused() {
    let mut program = Program::new();
    let mut inputs = Inputs::new(&mut program, SIDE);
    let context = program.context();
    unsafe {
        let reflections = make_reflections(context, &view(SIDE));
        let frame = inputs.frame();
        ssct_reflections_destroy(reflections);
        let assert_no_object = |result: SsctResult, name: &str| {
            assert_refused(result, &format!("is no {name}: it was destroyed, or never made"));
        };
        assert_no_object(ssct_reflections_record(reflections, program.commands, &frame, null_mut()), "SsctReflections");
        assert_no_object(ssct_reflections_resize(reflections, vk::Extent2D { width: 8, height: 8 }), "SsctReflections");
        assert_no_object(ssct_reflections_restart_history(reflections), "SsctReflections");
        assert_no_object(ssct_reflections_times(reflections, 0, &mut null(), &mut 0), "SsctReflections");
        // A second call of the function that destroys does nothing, and the sentence says so.
        ssct_reflections_destroy(reflections);
        assert!(last_sentence().contains("is no SsctReflections"), "{}", last_sentence());
        // The handle of a context is refused as triangles, and an address that the library did not return is refused as
        // any object.
        assert_no_object(ssct_triangles_record_upload(context.cast(), program.commands), "SsctTriangles");
        ssct_triangles_destroy(context.cast());
        assert!(last_sentence().contains("is no SsctTriangles"), "{}", last_sentence());
        assert_no_object(
            ssct_capture_cubes_record_face(dangling_mut(), program.commands, 0, null()),
            "SsctCaptureCubes",
        );
        let intact = make_reflections(context, &view(SIDE));
        for frame in [SsctFrame { captures: dangling(), ..frame }, SsctFrame { triangles: dangling(), ..frame }] {
            let result = ssct_reflections_record(intact, program.commands, &frame, null_mut());
            assert_refused(result, "it was destroyed, or never made");
        }
        ssct_context_destroy(context);
        assert_no_object(ssct_reflections_create(context, &view(SIDE), &mut null_mut()), "SsctContext");
        assert!(!ssct_context_has_timestamps(context) && last_sentence().contains("is no SsctContext"));
        ssct_reflections_destroy(intact);
    }
}

#[test]
fn two_threads_on_one_object_take_turns_or_are_refused() {
    let program = Program::new();
    let context = program.context();
    let reflections = make_reflections(context, &view(SIDE));
    let (address, context_address) = (reflections as usize, context as usize);
    let begin = Barrier::new(3);
    // All threads may use a context at once. One thread at a time may use reflections, and a second call at the same
    // time is refused.
    let resized: usize = std::thread::scope(|scope| {
        let resizing = |first_side: u32| {
            let begin = &begin;
            scope.spawn(move || {
                begin.wait();
                let mut done = 0;
                for call in 0..40 {
                    let side = first_side + call % 2;
                    let extent = vk::Extent2D { width: side, height: side };
                    let result = unsafe { ssct_reflections_resize(address as *mut SsctReflections, extent) };
                    match result {
                        SsctResult::Ok => done += 1,
                        _ => assert_refused(result, "is used by another call at the same time"),
                    }
                }
                done
            })
        };
        let threads = [resizing(16), resizing(24)];
        begin.wait();
        for _ in 0..40 {
            unsafe { ssct_context_trim(context_address as *const SsctContext) };
            assert!(unsafe { ssct_context_allocated_bytes(context_address as *const SsctContext) } > 0);
        }
        threads.into_iter().map(|thread| thread.join().unwrap()).sum()
    });
    assert!(resized > 0);
    // The reflections are whole, and can be used as before.
    let extent = vk::Extent2D { width: SIDE, height: SIDE };
    assert_ok(unsafe { ssct_reflections_resize(reflections, extent) });
    unsafe {
        ssct_reflections_destroy(reflections);
        ssct_context_destroy(context);
    }
}
