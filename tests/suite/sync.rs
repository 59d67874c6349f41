//! Tests the table of barriers: for each use of an image or buffer, the accesses that this use waits for and the
//! accesses that see its writes.

use ash::vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};
use ssct::gpu::sync::{Access, State};

/// Each use of the table says whether it writes, and each of its access flags has a stage that may make this access
/// (Vulkan 1.3, table 4). A flag without such a stage makes a barrier that waits for nothing.
#[test]
fn the_table_is_what_the_specification_asks_for() {
    for access in Access::ALL {
        let info = access.info();
        let write_bits = A::COLOR_ATTACHMENT_WRITE
            | A::DEPTH_STENCIL_ATTACHMENT_WRITE
            | A::SHADER_STORAGE_WRITE
            | A::ACCELERATION_STRUCTURE_WRITE_KHR
            | A::TRANSFER_WRITE;
        assert_eq!(info.writes, info.access.intersects(write_bits), "{access:?}");
        // The stages that may make an access (Vulkan 1.3, table 4).
        let flags_and_stages = [
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
        for (flags, stages) in flags_and_stages {
            if info.access.intersects(flags) {
                assert!(info.stages.intersects(stages), "{access:?}: {flags:?} without {stages:?}");
            }
        }
    }
    assert_eq!(Access::ColorAttachment.info().layout, L::COLOR_ATTACHMENT_OPTIMAL);
    assert_eq!(Access::ComputeStorage.info().layout, L::GENERAL);
    assert_eq!(Access::FragmentSampled.info().layout, L::SHADER_READ_ONLY_OPTIMAL);
}

/// A read after a write has a barrier, and a second read of the same kind has none. A missing barrier is a race, and a
/// needless one costs time.
#[test]
fn a_read_after_a_write_waits_for_it_once() {
    let mut state = State::default();
    let barrier = state.transition(Access::ColorAttachment).expect("from undefined");
    assert_eq!((barrier.old_layout, barrier.new_layout), (L::UNDEFINED, L::COLOR_ATTACHMENT_OPTIMAL));
    let barrier = state.transition(Access::FragmentSampled).expect("write, then read");
    assert!(barrier.src_access.contains(A::COLOR_ATTACHMENT_WRITE) && barrier.dst_access == A::SHADER_READ);
    assert_eq!(state.transition(Access::FragmentSampled), None, "the same read again");
}

/// A read in another stage has a barrier of its own, without a change of layout, since the first barrier made the write
/// visible to its own stage alone.
#[test]
fn a_second_reader_stage_is_made_to_see_the_write() {
    let mut state = State::default();
    state.transition(Access::ComputeStorage);
    state.transition(Access::FragmentSampled);
    let barrier = state.transition(Access::ComputeSampled).expect("another stage");
    assert_eq!((barrier.src_stages, barrier.dst_stages), (S::FRAGMENT_SHADER, S::COMPUTE_SHADER));
    assert_eq!(barrier.old_layout, barrier.new_layout);
}

/// A write after reads in two stages waits for both stages, and a write after a write waits for that write. A state
/// that remembers only the last reader would let the write overtake the other.
#[test]
fn a_write_waits_for_every_reader_and_for_the_write_before_it() {
    let mut state = State::default();
    state.transition(Access::TransferWrite);
    state.transition(Access::FragmentSampled);
    state.transition(Access::ComputeSampled);
    let barrier = state.transition(Access::ColorAttachment).expect("write after reads");
    assert!(barrier.src_stages.contains(S::FRAGMENT_SHADER | S::COMPUTE_SHADER));
    let barrier = state.transition(Access::ColorAttachment).expect("write after write");
    assert!(barrier.src_access.contains(A::COLOR_ATTACHMENT_WRITE));
}

/// The first use of a swapchain image waits for its acquisition, and the presentation waits for the last write.
/// Otherwise the window could show half a frame.
#[test]
fn an_acquired_image_is_touched_after_the_acquisition_and_presented_after_the_write() {
    let mut state = State::acquired(S::ALL_TRANSFER);
    let barrier = state.transition(Access::TransferWrite).expect("from undefined");
    assert_eq!((barrier.src_stages, barrier.dst_stages), (S::ALL_TRANSFER, S::ALL_TRANSFER));
    assert_eq!((barrier.old_layout, barrier.new_layout), (L::UNDEFINED, L::TRANSFER_DST_OPTIMAL));
    let barrier = state.transition(Access::Present).expect("another layout");
    assert_eq!((barrier.src_stages, barrier.src_access), (S::ALL_TRANSFER, A::TRANSFER_WRITE));
    assert_eq!(barrier.new_layout, L::PRESENT_SRC_KHR);
}

/// The buffers of an indirect draw have the right barriers from clear to count, from count to draw, and from draw to
/// the next clear. The draw reads its arguments in a stage of its own, which no other barrier covers.
#[test]
fn arguments_and_lists_that_a_dispatch_wrote_are_seen_by_the_draw() {
    let (mut arguments, mut lists) = (State::default(), State::default());
    arguments.transition(Access::TransferWrite);
    let barrier = arguments.transition(Access::ComputeStorage).expect("clear, then count");
    assert_eq!((barrier.src_stages, barrier.src_access), (S::ALL_TRANSFER, A::TRANSFER_WRITE));
    let barrier = arguments.transition(Access::Indirect).expect("count, then draw");
    assert_eq!((barrier.src_stages, barrier.dst_stages), (S::COMPUTE_SHADER, S::DRAW_INDIRECT));
    assert!(barrier.src_access.contains(A::SHADER_STORAGE_WRITE) && barrier.dst_access == A::INDIRECT_COMMAND_READ);
    let barrier = arguments.transition(Access::TransferWrite).expect("the next frame's clear");
    assert!(barrier.src_stages.contains(S::DRAW_INDIRECT));
    lists.transition(Access::ComputeStorage);
    let barrier = lists.transition(Access::GraphicsStorageRead).expect("list, then draw");
    assert!(barrier.dst_stages.contains(S::VERTEX_SHADER) && barrier.dst_access == A::SHADER_STORAGE_READ);
}

/// Two dispatches that write one storage buffer have a barrier between them. Both are the same use, for which a table
/// of reads would need none.
#[test]
fn storage_written_twice_has_a_barrier_between_dispatches() {
    let mut state = State::default();
    state.transition(Access::ComputeStorage);
    let barrier = state.transition(Access::ComputeStorage).expect("dispatch after dispatch");
    assert!(
        barrier.src_access.contains(A::SHADER_STORAGE_WRITE) && barrier.dst_access.contains(A::SHADER_STORAGE_READ)
    );
}
