//! Tests mistakes of host programs: colours that are no numbers are black and spread nowhere, and an instance that was
//! made for an older Vulkan is refused.

use crate::common::engine::{Engine, ForeignGBuffer, NATIVE, bits, info, view_of_rooms};
use crate::common::gpu;
use ash::vk;
use glam::Vec3;
use ssct::methods::{METHODS, Setup};
use ssct::{Context, DeviceHandles, EnabledFeatures, Reflections};
use ssct_lab::stage::gbuffer;

/// NaN in a colour counts as 0, and infinity as the greatest 16-bit float. Every screen-space method makes the same
/// bits of a G-buffer with these numbers, from the host and through the door. A blur would spread NaN over the image.
#[test]
fn a_colour_that_is_no_number_is_black_and_spreads_nowhere() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let context = engine.context();
    let plain = view_of_rooms(&gpu, [97, 61]);
    let with_color = |odd: [f32; 3]| {
        let mut data = plain.clone();
        data.roughness.fill(0.3);
        data.color.iter_mut().skip(40).step_by(211).for_each(|color| *color = Vec3::from(odd));
        data
    };
    // The greatest finite 16-bit float, to which an infinite colour is clamped.
    const MOST: f32 = 65504.0;
    for (odd, sound) in [
        ([f32::NAN; 3], [0.0; 3]),
        ([0.5, -f32::NAN, 0.25], [0.5, 0.0, 0.25]),
        ([f32::INFINITY, 1.0, f32::NEG_INFINITY], [MOST, 1.0, -MOST]),
    ] {
        let (odd, sound) = (with_color(odd), with_color(sound));
        let theirs = ForeignGBuffer::new(&mut engine, &odd, NATIVE);
        for method in METHODS.iter().filter(|m| m.is_screen_space()) {
            let reflect = |data| gbuffer::reflect(&gpu, data, None, method, &Setup::new([97, 61])).unwrap();
            let [expected, uploaded] = [&sound, &odd].map(reflect);
            assert!(bits(&uploaded.composite) == bits(&expected.composite), "{}: from the host", method.name);
            let mut reflections = Reflections::new(&context, &info(&odd, method.name)).unwrap();
            let recorded = engine.frame(&mut reflections, &theirs.input()).unwrap();
            let composite = engine.read(&recorded.composite.unwrap());
            assert!(bits(&composite) == bits(&expected.composite), "{}: through the door", method.name);
        }
    }
    gpu.check_validation().unwrap();
}

/// A context on an instance of Vulkan 1.2 is refused with a sentence. Calls of Vulkan 1.3 would crash there.
#[test]
fn an_instance_of_an_older_version_is_refused() {
    // SAFETY: the handles belong together and are destroyed after the context was refused.
    unsafe {
        let entry = ash::Entry::load().unwrap();
        let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_2);
        let info = vk::InstanceCreateInfo::default().application_info(&application);
        let instance = entry.create_instance(&info, None).unwrap();
        let physical = instance.enumerate_physical_devices().unwrap()[0];
        let queues = [vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
        let device = instance.create_device(physical, &info, None).unwrap();
        let handles = DeviceHandles {
            entry,
            instance: instance.clone(),
            physical,
            device: device.clone(),
            queue_family: 0,
            enabled: EnabledFeatures::default(),
            debug_utils: false,
            memory: None,
        };
        let message = Context::new(handles).err().unwrap().to_string();
        assert!(message.contains("the instance was not made for Vulkan 1.3"), "{message}");
        device.destroy_device(None);
        instance.destroy_instance(None);
    }
}
