// A renderer in plain C11 that takes reflections from ssct: its own instance, device and images. It ray-traces the G-buffer
// of a hall at dusk on the CPU (hall.h), copies it to the device, records "unified" into its own command buffer, submits
// once, and writes the composite to a picture. The lines that reflections need stand between "reflections" marks.
//
//     cc -std=c11 -O2 main.c $(pkg-config --cflags --libs ssct vulkan) -lm -o hall
//     ./hall out.ppm [FOLDER]    # with a folder, every image is also written there as 32-bit floats

#include "hall.h"

#include <ssct.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PIXELS = WIDTH * HEIGHT, COMPOSITE_BYTES = PIXELS * 4 * sizeof(uint16_t) };

static const VkFormat HALF = VK_FORMAT_R16G16B16A16_SFLOAT;

// Prints which action failed and why, and ends the program.
static void fail(const char *what, const char *why) {
    fprintf(stderr, "hall: %s: %s\n", what, why);
    exit(1);
}

static void check(VkResult result, const char *what) {
    char why[32];
    snprintf(why, sizeof why, "VkResult %d", (int)result);
    if (result != VK_SUCCESS) fail(what, why);
}

static void check_ssct(SsctResult result, const char *what) {
    if (result != SSCT_RESULT_OK) fail(what, ssct_last_error());
}

// The device with its first queue; `features` are the ones that it was made with.
typedef struct {
    VkInstance instance;
    VkPhysicalDevice physical;
    VkDevice device;
    VkQueue queue;
    uint32_t family;
    VkPhysicalDeviceFeatures features;
    VkPhysicalDeviceVulkan12Features features12;
    VkPhysicalDeviceVulkan13Features features13;
} Device;

// An image of WIDTH x HEIGHT with its view and memory.
typedef struct {
    VkImage image;
    VkImageView view;
    VkDeviceMemory memory;
    VkFormat format;
    VkImageAspectFlags aspect;
} Picture;

// A buffer whose memory the host sees at `mapped`.
typedef struct {
    VkBuffer buffer;
    VkDeviceMemory memory;
    void *mapped;
} Buffer;

// Returns the index of the first queue family that has both graphics and compute; UINT32_MAX if there is none.
static uint32_t universal_family(VkPhysicalDevice physical) {
    VkQueueFamilyProperties families[16];
    uint32_t count = 16;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families);
    const VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    for (uint32_t i = 0; i < count; i++)
        if ((families[i].queueFlags & wanted) == wanted) return i;
    return UINT32_MAX;
}

// Opens the first Vulkan device, with the features that ssct needs.
static Device open_device(void) {
    Device d = {0};
    VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
    VkInstanceCreateInfo instance = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pApplicationInfo = &application,
    };
    check(vkCreateInstance(&instance, NULL, &d.instance), "vkCreateInstance");
    uint32_t count = 1;
    vkEnumeratePhysicalDevices(d.instance, &count, &d.physical);
    if (count == 0) fail("vkEnumeratePhysicalDevices", "there is no Vulkan device");
    d.family = universal_family(d.physical);
    if (d.family == UINT32_MAX) fail("the device", "it has no queue for graphics and compute");
    d.features12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    d.features13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;

    // ---- reflections ----
    check_ssct(ssct_enable_features(&d.features, &d.features12, &d.features13), "ssct_enable_features");
    // ---------------------

    VkPhysicalDeviceVulkan12Features features12 = d.features12;
    VkPhysicalDeviceVulkan13Features features13 = d.features13;
    features13.pNext = &features12;
    const float priority = 1;
    VkDeviceQueueCreateInfo queue = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
        .queueFamilyIndex = d.family,
        .queueCount = 1,
        .pQueuePriorities = &priority,
    };
    VkDeviceCreateInfo device = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
        .pNext = &features13,
        .queueCreateInfoCount = 1,
        .pQueueCreateInfos = &queue,
        .pEnabledFeatures = &d.features,
    };
    check(vkCreateDevice(d.physical, &device, NULL, &d.device), "vkCreateDevice");
    vkGetDeviceQueue(d.device, d.family, 0, &d.queue);
    return d;
}

// Allocates memory that has the properties `like`. Each image and buffer gets an allocation of its own, since there are
// few.
static VkDeviceMemory memory_for(const Device *d, VkMemoryRequirements needs, VkMemoryPropertyFlags like) {
    VkPhysicalDeviceMemoryProperties types;
    vkGetPhysicalDeviceMemoryProperties(d->physical, &types);
    uint32_t type = 0;
    while (type < types.memoryTypeCount &&
           !((needs.memoryTypeBits >> type & 1) && (types.memoryTypes[type].propertyFlags & like) == like))
        type++;
    if (type == types.memoryTypeCount) fail("memory", "the device has no such type");
    VkMemoryAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
        .allocationSize = needs.size,
        .memoryTypeIndex = type,
    };
    VkDeviceMemory memory;
    check(vkAllocateMemory(d->device, &info, NULL, &memory), "vkAllocateMemory");
    return memory;
}

// Makes an image that is copied to and then sampled.
static Picture make_picture(const Device *d, VkFormat format, VkImageAspectFlags aspect) {
    Picture p = {.format = format, .aspect = aspect};
    VkImageCreateInfo image = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .imageType = VK_IMAGE_TYPE_2D,
        .format = format,
        .extent = {WIDTH, HEIGHT, 1},
        .mipLevels = 1,
        .arrayLayers = 1,
        .samples = VK_SAMPLE_COUNT_1_BIT,
        .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
    };
    check(vkCreateImage(d->device, &image, NULL, &p.image), "vkCreateImage");
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(d->device, p.image, &needs);
    p.memory = memory_for(d, needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    check(vkBindImageMemory(d->device, p.image, p.memory, 0), "vkBindImageMemory");
    VkImageViewCreateInfo view = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .image = p.image,
        .viewType = VK_IMAGE_VIEW_TYPE_2D,
        .format = format,
        .subresourceRange = {aspect, 0, 1, 0, 1},
    };
    check(vkCreateImageView(d->device, &view, NULL, &p.view), "vkCreateImageView");
    return p;
}

// Makes a buffer that stays mapped.
static Buffer make_buffer(const Device *d, VkDeviceSize size, VkBufferUsageFlags usage) {
    Buffer b;
    VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = usage};
    check(vkCreateBuffer(d->device, &info, NULL, &b.buffer), "vkCreateBuffer");
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(d->device, b.buffer, &needs);
    b.memory = memory_for(d, needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    check(vkBindBufferMemory(d->device, b.buffer, b.memory, 0), "vkBindBufferMemory");
    check(vkMapMemory(d->device, b.memory, 0, VK_WHOLE_SIZE, 0, &b.mapped), "vkMapMemory");
    return b;
}

// The copy between a whole image and a buffer from the byte `offset` on.
static VkBufferImageCopy whole(VkDeviceSize offset, VkImageAspectFlags aspect) {
    return (VkBufferImageCopy){
        .bufferOffset = offset,
        .imageSubresource = {aspect, 0, 0, 1},
        .imageExtent = {WIDTH, HEIGHT, 1},
    };
}

// Records the copy of a buffer to an image, which is left in the layout TRANSFER_DST_OPTIMAL.
static void upload(VkCommandBuffer commands, const Buffer *from, VkDeviceSize offset, const Picture *to) {
    VkImageMemoryBarrier2 barrier = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
        .dstStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
        .dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
        .newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = to->image,
        .subresourceRange = {to->aspect, 0, 1, 0, 1},
    };
    VkDependencyInfo dependency = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
        .imageMemoryBarrierCount = 1,
        .pImageMemoryBarriers = &barrier,
    };
    vkCmdPipelineBarrier2(commands, &dependency);
    VkBufferImageCopy copy = whole(offset, to->aspect);
    vkCmdCopyBufferToImage(commands, from->buffer, to->image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
}

// Records the copy of an image to a buffer, and a barrier so that the host can read the buffer afterwards.
static void download(VkCommandBuffer commands, VkImage from, const Buffer *to) {
    VkBufferImageCopy copy = whole(0, VK_IMAGE_ASPECT_COLOR_BIT);
    vkCmdCopyImageToBuffer(commands, from, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to->buffer, 1, &copy);
    VkMemoryBarrier2 barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
        .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
        .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
        .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT,
    };
    VkDependencyInfo dependency = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
        .memoryBarrierCount = 1,
        .pMemoryBarriers = &barrier,
    };
    vkCmdPipelineBarrier2(commands, &dependency);
}

// ---- reflections ----

// Makes the context of ssct on the device, and prints the name of the device.
static SsctContext *make_context(const Device *d) {
    SsctContextInfo info = {
        .struct_size = sizeof info,
        .get_instance_proc_addr = vkGetInstanceProcAddr,
        .instance = d->instance,
        .physical_device = d->physical,
        .device = d->device,
        .queue_family = d->family,
        .features = &d->features,
        .features12 = &d->features12,
        .features13 = &d->features13,
    };
    SsctContext *context;
    check_ssct(ssct_context_create(&info, &context), "ssct_context_create");
    SsctDeviceInfo device = {.struct_size = sizeof device};
    check_ssct(ssct_context_device_info(context, &device), "ssct_context_device_info");
    printf("%s\n", device.name);
    return context;
}

// Makes the reflections by "unified", without its fade at the borders of the screen.
static SsctReflections *make_reflections(const SsctContext *context) {
    const SsctParameter parameters[] = {{"fade", "off"}};
    SsctReflectionsInfo info = {
        .struct_size = sizeof info,
        .extent = {WIDTH, HEIGHT},
        .method = "unified",
        .parameters = parameters,
        .parameter_count = 1,
        .outputs = SSCT_OUTPUT_COMPOSITE,
    };
    SsctReflections *reflections;
    check_ssct(ssct_reflections_create(context, &info, &reflections), "ssct_reflections_create");
    return reflections;
}

// Describes an input image. A copy wrote it last, as `before` says; afterwards it is sampled, which is the default of
// `after`.
static SsctImage input(const Picture *p) {
    return (SsctImage){
        .struct_size = sizeof(SsctImage),
        .image = p->image,
        .view = p->view,
        .format = p->format,
        .extent = {WIDTH, HEIGHT},
        .before = ssct_image_use(SSCT_USE_TRANSFER_TARGET),
    };
}

// Records the reflections. Returns the composite, which is left in the layout from which an image is copied.
static VkImage record(SsctReflections *reflections, VkCommandBuffer commands, const Picture pictures[4], bool timed) {
    SsctImage depth = input(&pictures[0]), normal = input(&pictures[1]), material = input(&pictures[2]);
    SsctImage color = input(&pictures[3]);
    SsctCamera camera = {.struct_size = sizeof camera, .clip_y = SSCT_CLIP_Y_DOWN};
    hall_camera(camera.view_to_clip, camera.world_to_view);
    SsctNormals normals = {
        .struct_size = sizeof normals,
        .image = &normal,
        .space = SSCT_NORMAL_SPACE_VIEW,
        .encoding = SSCT_NORMAL_ENCODING_FLOAT,
    };
    SsctFactor reflectivity = {.struct_size = sizeof reflectivity, .image = &material, .channel = 0};
    SsctFactor roughness = {.struct_size = sizeof roughness, .image = &material, .channel = 1};
    SsctFrame frame = {
        .struct_size = sizeof frame,
        .slot = 0,
        .timed = timed,
        .camera = &camera,
        .depth = &depth,
        .normals = &normals,
        .reflectivity = &reflectivity,
        .roughness = &roughness,
        .color = &color,
        .outputs = ssct_image_use(SSCT_USE_TRANSFER_SOURCE),
    };
    SsctRecorded recorded = {.struct_size = sizeof recorded};
    check_ssct(ssct_reflections_record(reflections, commands, &frame, &recorded), "ssct_reflections_record");
    return recorded.composite.image;
}

// Prints how long each pass took on the device.
static void print_times(SsctReflections *reflections) {
    const SsctPassTime *times;
    uint32_t count;
    check_ssct(ssct_reflections_times(reflections, 0, &times, &count), "ssct_reflections_times");
    for (uint32_t i = 0; i < count; i++) printf("%7.2f ms  %s\n", times[i].ms, times[i].name);
}

// ---------------------

// Writes bytes to a file of the folder, or to the path `name` if `folder` is empty.
static void write_file(const char *folder, const char *name, const void *bytes, size_t size) {
    char path[4096];
    snprintf(path, sizeof path, "%s%s%s", folder, *folder ? "/" : "", name);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, size, file) != size || fclose(file) != 0) fail(path, "it cannot be written");
}

// Writes an image of 16-bit floats as 32-bit floats.
static void write_halves(const char *folder, const char *name, const uint16_t *halves) {
    float *numbers = malloc(PIXELS * 4 * sizeof *numbers);
    if (!numbers) fail(name, "there is no memory");
    for (size_t i = 0; i < PIXELS * 4; i++) numbers[i] = float_of_half(halves[i]);
    write_file(folder, name, numbers, PIXELS * 4 * sizeof *numbers);
    free(numbers);
}

// Writes an image of linear light as a portable pixmap, with the tone curve of `shown`.
static void write_ppm(const char *path, const uint16_t *halves) {
    char header[32];
    const size_t head = (size_t)snprintf(header, sizeof header, "P6\n%d %d\n255\n", WIDTH, HEIGHT);
    unsigned char *bytes = malloc(head + PIXELS * 3);
    if (!bytes) fail(path, "there is no memory");
    memcpy(bytes, header, head);
    for (size_t i = 0; i < PIXELS * 3; i++) bytes[head + i] = display_byte(float_of_half(halves[i / 3 * 4 + i % 3]));
    write_file("", path, bytes, head + PIXELS * 3);
    free(bytes);
}

int main(int argc, char **argv) {
    const char *path = argc > 1 ? argv[1] : "hall.ppm";
    Device d = open_device();
    Hall *hall = malloc(sizeof *hall);
    if (!hall) fail("the hall", "there is no memory");
    draw_hall(hall);

    const VkFormat formats[4] = {VK_FORMAT_D32_SFLOAT, HALF, HALF, HALF};
    Picture pictures[4];
    for (int i = 0; i < 4; i++)
        pictures[i] = make_picture(&d, formats[i], i == 0 ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT);
    Buffer staging = make_buffer(&d, sizeof *hall, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    Buffer readback = make_buffer(&d, COMPOSITE_BYTES, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    memcpy(staging.mapped, hall, sizeof *hall);

    VkCommandPoolCreateInfo pool_info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .queueFamilyIndex = d.family,
    };
    VkCommandPool pool;
    check(vkCreateCommandPool(d.device, &pool_info, NULL, &pool), "vkCreateCommandPool");
    VkCommandBufferAllocateInfo allocate = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = pool,
        .commandBufferCount = 1,
    };
    VkCommandBuffer commands;
    check(vkAllocateCommandBuffers(d.device, &allocate, &commands), "vkAllocateCommandBuffers");
    VkCommandBufferBeginInfo begin = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
        .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
    };
    check(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
    const size_t offsets[4] = {
        offsetof(Hall, depth), offsetof(Hall, normal), offsetof(Hall, material), offsetof(Hall, color),
    };
    for (int i = 0; i < 4; i++) upload(commands, &staging, offsets[i], &pictures[i]);

    // ---- reflections ----
    SsctContext *context = make_context(&d);
    SsctReflections *reflections = make_reflections(context);
    const bool timed = ssct_context_has_timestamps(context);
    VkImage composite = record(reflections, commands, pictures, timed);
    // ---------------------

    download(commands, composite, &readback);
    check(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
    VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
        .commandBufferCount = 1,
        .pCommandBuffers = &commands,
    };
    check(vkQueueSubmit(d.queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
    check(vkQueueWaitIdle(d.queue), "vkQueueWaitIdle");

    // ---- reflections ----
    if (timed) print_times(reflections);
    ssct_reflections_destroy(reflections); // before the device
    ssct_context_destroy(context);
    // ---------------------

    write_ppm(path, readback.mapped);
    if (argc > 2) {
        float camera[32];
        hall_camera(camera, camera + 16);
        write_file(argv[2], "camera.f32", camera, sizeof camera);
        write_file(argv[2], "depth.f32", hall->depth, sizeof hall->depth);
        write_halves(argv[2], "normal.f32", hall->normal);
        write_halves(argv[2], "material.f32", hall->material);
        write_halves(argv[2], "color.f32", hall->color);
        write_halves(argv[2], "composite.f32", readback.mapped);
    }

    free(hall);
    vkDestroyCommandPool(d.device, pool, NULL);
    for (int i = 0; i < 4; i++) {
        vkDestroyImageView(d.device, pictures[i].view, NULL);
        vkDestroyImage(d.device, pictures[i].image, NULL);
        vkFreeMemory(d.device, pictures[i].memory, NULL);
    }
    const Buffer buffers[2] = {staging, readback};
    for (int i = 0; i < 2; i++) {
        vkDestroyBuffer(d.device, buffers[i].buffer, NULL);
        vkFreeMemory(d.device, buffers[i].memory, NULL);
    }
    vkDestroyDevice(d.device, NULL);
    vkDestroyInstance(d.instance, NULL);
    return 0;
}
