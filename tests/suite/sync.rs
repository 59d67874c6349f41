//! The table of barriers: for each use of an image or buffer, the accesses that it waits for and the accesses that see
//! it.

use ash::vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};
use ssct::gpu::sync::{Access, State};

/// Each use of the table says whether it writes, and each of its access flags has a stage that may make this access
/// (Vulkan 1.3, table 4).
#[test]
fn the_table_is_what_the_specification_asks_for() {
    for access in Access::ALL {
        let i = access.info();
        let write_bits = A::COLOR_ATTACHMENT_WRITE
            | A::DEPTH_STENCIL_ATTACHMENT_WRITE
            | A::SHADER_STORAGE_WRITE
            | A::ACCELERATION_STRUCTURE_WRITE_KHR
            | A::TRANSFER_WRITE;
        assert_eq!(i.writes, i.access.intersects(write_bits), "{access:?}");
        // Every access flag belongs to one of its stages (Vulkan 1.3, table 4).
        let pairs = [
            (A::COLOR_ATTACHMENT_READ | A::COLOR_ATTACHMENT_WRITE, S::COLOR_ATTACHMENT_OUTPUT),
            (
                A::DEPTH_STENCIL_ATTACHMENT_READ | A::DEPTH_STENCIL_ATTACHMENT_WRITE,
                S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS,
            ),
            (
                A::SHADER_READ | A::SHADER_STORAGE_READ,
                S::VERTEX_SHADER | S::FRAGMENT_SHADER | S::COMPUTE_SHADER | S::ACCELERATION_STRUCTURE_BUILD_KHR,
            ),
            (A::ACCELERATION_STRUCTURE_READ_KHR, S::ACCELERATION_STRUCTURE_BUILD_KHR | S::COMPUTE_SHADER),
            (A::ACCELERATION_STRUCTURE_WRITE_KHR, S::ACCELERATION_STRUCTURE_BUILD_KHR),
            (A::SHADER_STORAGE_WRITE, S::FRAGMENT_SHADER | S::COMPUTE_SHADER),
            (A::TRANSFER_READ | A::TRANSFER_WRITE, S::ALL_TRANSFER),
            (A::VERTEX_ATTRIBUTE_READ | A::INDEX_READ, S::VERTEX_INPUT),
            (A::INDIRECT_COMMAND_READ, S::DRAW_INDIRECT),
            (A::HOST_READ, S::HOST),
        ];
        for (flags, stages) in pairs {
            if i.access.intersects(flags) {
                assert!(i.stages.intersects(stages), "{access:?}: {flags:?} without {stages:?}");
            }
        }
    }
    assert_eq!(Access::ColorAttachment.info().layout, L::COLOR_ATTACHMENT_OPTIMAL);
    assert_eq!(Access::ComputeStorage.info().layout, L::GENERAL);
    assert_eq!(Access::FragmentSampled.info().layout, L::SHADER_READ_ONLY_OPTIMAL);
}

/// A read after a write has a barrier, and a second read of that kind has none.
#[test]
fn a_read_after_a_write_waits_for_it_once() {
    let mut s = State::default();
    let t = s.transition(Access::ColorAttachment).expect("from undefined");
    assert_eq!((t.old_layout, t.new_layout), (L::UNDEFINED, L::COLOR_ATTACHMENT_OPTIMAL));
    let t = s.transition(Access::FragmentSampled).expect("write, then read");
    assert!(t.src_access.contains(A::COLOR_ATTACHMENT_WRITE) && t.dst_access == A::SHADER_READ);
    assert_eq!(s.transition(Access::FragmentSampled), None, "the same read again");
}

/// A read in another stage has a barrier of its own, without a change of layout.
#[test]
fn a_second_reader_stage_is_made_to_see_the_write() {
    let mut s = State::default();
    s.transition(Access::ComputeStorage);
    s.transition(Access::FragmentSampled);
    let t = s.transition(Access::ComputeSampled).expect("another stage");
    assert_eq!((t.src_stages, t.dst_stages), (S::FRAGMENT_SHADER, S::COMPUTE_SHADER));
    assert_eq!(t.old_layout, t.new_layout);
}

/// A write after reads in two stages waits for both stages, and a write after a write waits for that write.
#[test]
fn a_write_waits_for_every_reader_and_for_the_write_before_it() {
    let mut s = State::default();
    s.transition(Access::TransferWrite);
    s.transition(Access::FragmentSampled);
    s.transition(Access::ComputeSampled);
    let t = s.transition(Access::ColorAttachment).expect("write after reads");
    assert!(t.src_stages.contains(S::FRAGMENT_SHADER | S::COMPUTE_SHADER));
    let t = s.transition(Access::ColorAttachment).expect("write after write");
    assert!(t.src_access.contains(A::COLOR_ATTACHMENT_WRITE));
}

/// The first use of a swapchain image waits for its acquisition, and the presentation waits for the last write.
#[test]
fn an_acquired_image_is_touched_after_the_acquisition_and_presented_after_the_write() {
    let mut s = State::acquired(S::ALL_TRANSFER);
    let t = s.transition(Access::TransferWrite).expect("from undefined");
    assert_eq!((t.src_stages, t.dst_stages), (S::ALL_TRANSFER, S::ALL_TRANSFER));
    assert_eq!((t.old_layout, t.new_layout), (L::UNDEFINED, L::TRANSFER_DST_OPTIMAL));
    let t = s.transition(Access::Present).expect("another layout");
    assert_eq!((t.src_stages, t.src_access), (S::ALL_TRANSFER, A::TRANSFER_WRITE));
    assert_eq!(t.new_layout, L::PRESENT_SRC_KHR);
}

/// Buffers of an indirect draw, from clear to count to draw and to the next clear, have the right barriers.
#[test]
fn arguments_and_lists_that_a_dispatch_wrote_are_seen_by_the_draw() {
    let (mut arguments, mut lists) = (State::default(), State::default());
    arguments.transition(Access::TransferWrite);
    let t = arguments.transition(Access::ComputeStorage).expect("clear, then count");
    assert_eq!((t.src_stages, t.src_access), (S::ALL_TRANSFER, A::TRANSFER_WRITE));
    let t = arguments.transition(Access::Indirect).expect("count, then draw");
    assert_eq!((t.src_stages, t.dst_stages), (S::COMPUTE_SHADER, S::DRAW_INDIRECT));
    assert!(t.src_access.contains(A::SHADER_STORAGE_WRITE) && t.dst_access == A::INDIRECT_COMMAND_READ);
    let t = arguments.transition(Access::TransferWrite).expect("the next frame's clear");
    assert!(t.src_stages.contains(S::DRAW_INDIRECT));
    lists.transition(Access::ComputeStorage);
    let t = lists.transition(Access::GraphicsStorageRead).expect("list, then draw");
    assert!(t.dst_stages.contains(S::VERTEX_SHADER) && t.dst_access == A::SHADER_STORAGE_READ);
}

#[test]
fn storage_written_twice_has_a_barrier_between_dispatches() {
    let mut s = State::default();
    s.transition(Access::ComputeStorage);
    let t = s.transition(Access::ComputeStorage).expect("dispatch after dispatch");
    assert!(t.src_access.contains(A::SHADER_STORAGE_WRITE) && t.dst_access.contains(A::SHADER_STORAGE_READ));
}
