// Glossy reflections in screen space on Vulkan, recorded into your command buffer, on your device, from your images.
// docs/embedding.md builds a renderer that does so from nothing, and examples/c is such a renderer.
//
// Written by cbindgen from c/src; `make docs` writes it anew.
//
// Structs. You fill in a struct that begins with `struct_size`, and set this field to sizeof of the struct; its other fields
// may be zero where a default is named. Later versions add fields at the end. This library takes a longer struct if all
// fields that it does not know are zero. Pointers in such structs are read during the call alone, except for the functions
// of SsctMemory.
//
// Failures. A function that can fail returns an SsctResult, and `ssct_last_error` has a sentence on it for the thread that
// called. A fault of the library comes to you in no other way: an object in which a fault occurred returns
// SSCT_RESULT_INTERNAL from then on, and can be destroyed. The library cannot check what Vulkan does not tell of a handle,
// such as the usage that an image was really made with: turn the validation layers on for that.
//
// Lifetimes. Instance, device and loader outlive every object. Objects may be destroyed in any order, even a context before
// the objects that were made with it, once the device is done with what was recorded. Output images are destroyed with their
// reflections. A call on an object that was destroyed, or that is of another type, is refused, unless another object has its
// address by now.
//
// Threads. Several threads may use a context at once. Any thread may use any other object, but one thread at a time;
// different objects, even of one context, may be used by different threads at once. While a frame is recorded, it reads the
// capture cubes and the triangles that it is given. A call that uses or destroys an object is refused while another call
// uses the object. Nothing here submits, waits or presents.


#ifndef SSCT_H
#define SSCT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

/// How a call ended. `ssct_last_error` has a sentence on every code but SSCT_RESULT_OK.
typedef enum SsctResult {
  /// The call did what it is for.
  SSCT_RESULT_OK = 0,
  /// An argument is wrong, and the sentence says which. Nothing was done.
  SSCT_RESULT_USAGE = 1,
  /// The device cannot be used: it has no Vulkan 1.3, a feature is off, or the queue family does not fit.
  SSCT_RESULT_NO_DEVICE = 2,
  /// There is not enough memory on the device or on the host.
  SSCT_RESULT_MEMORY = 3,
  /// A Vulkan call failed. The sentence names the call and what the driver returned.
  SSCT_RESULT_VULKAN = 4,
  /// The device is lost. Destroying objects is safe.
  SSCT_RESULT_DEVICE_LOST = 5,
  /// The device is not done with the frame yet.
  SSCT_RESULT_NOT_READY = 6,
  /// The library has a fault. The object of the call does nothing more; destroy it.
  SSCT_RESULT_INTERNAL = 7,
} SsctResult;

/// Cubes of images of the scene around places, in which the methods "unified" and "captures" follow the rays that the
/// screen loses. You draw the faces, and hand over each face at least once, and again whenever you like.
typedef struct SsctCaptureCubes SsctCaptureCubes;

/// A device of yours that reflections are recorded for. Destroying the context destroys none of your handles.
typedef struct SsctContext SsctContext;

/// The pipelines, images and uniform memory that reflect one view in every frame.
typedef struct SsctReflections SsctReflections;

/// Triangles of the scene, among which the methods "unified" and "traced" follow rays. A ray that hits a triangle sees
/// the colour or the texture of the triangle's mesh. If something moved, make new triangles, and keep the old ones
/// until the device is done with them.
typedef struct SsctTriangles SsctTriangles;

/// The kind of memory that a buffer or an image lives in: one of SSCT_MEMORY_PLACE_*.
typedef uint32_t SsctMemoryPlace;

/// A part of a memory object. No one else uses the part until the library releases it.
typedef struct SsctMemoryBlock {
  /// The memory object.
  VkDeviceMemory memory;
  /// Where the part begins, in bytes.
  uint64_t offset;
  /// The address at which the host sees the part; NULL for SSCT_MEMORY_PLACE_DEVICE.
  void *mapped;
  /// A number of your choice, which you get back with the block.
  uint64_t key;
} SsctMemoryBlock;

/// An allocator of your own, in place of the library's. The threads that call the library call the allocator's
/// functions, but never two threads at once for one context.
typedef struct SsctMemory {
  /// sizeof(SsctMemory).
  size_t struct_size;
  /// A pointer of your choice, which the library passes to both functions.
  void *user_data;
  /// Writes to `block` a part of memory that fits the requirements, and returns NULL. If there is no such memory,
  /// returns a clause that says why; the text must stay until the next call. `name` is the name of the image or
  /// buffer. `linear` is false for images of optimal tiling.
  const char *(*allocate)(void *user_data,
                          const char *name,
                          const VkMemoryRequirements *requirements,
                          SsctMemoryPlace place,
                          bool linear,
                          struct SsctMemoryBlock *block);
  /// Takes back a block whose image or buffer is already destroyed.
  void (*release)(void *user_data, const struct SsctMemoryBlock *block);
} SsctMemory;

/// A device that you made, with all features on that `ssct_enable_features` turns on.
typedef struct SsctContextInfo {
  /// sizeof(SsctContextInfo).
  size_t struct_size;
  /// The loader's function, if you loaded it yourself; NULL for the system's loader.
  PFN_vkGetInstanceProcAddr get_instance_proc_addr;
  /// The instance, made for Vulkan 1.3 (VkApplicationInfo::apiVersion).
  VkInstance instance;
  /// The physical device.
  VkPhysicalDevice physical_device;
  /// The device.
  VkDevice device;
  /// The family of the queues that you submit to; it does both graphics and compute.
  uint32_t queue_family;
  /// Whether the instance has VK_EXT_debug_utils on: passes and objects then have names.
  VkBool32 debug_utils;
  /// The features of Vulkan 1.0 that are on.
  const VkPhysicalDeviceFeatures *features;
  /// The features of Vulkan 1.2 that are on; structs that are chained to it are ignored.
  const VkPhysicalDeviceVulkan12Features *features12;
  /// The features of Vulkan 1.3 that are on; structs that are chained to it are ignored.
  const VkPhysicalDeviceVulkan13Features *features13;
  /// Your allocator; NULL for the library's own.
  const struct SsctMemory *memory;
} SsctContextInfo;

/// Name, driver, version and kind of a device. The texts stay until the context is destroyed.
typedef struct SsctDeviceInfo {
  /// sizeof(SsctDeviceInfo).
  size_t struct_size;
  /// The device's name.
  const char *name;
  /// Name and version of the driver.
  const char *driver;
  /// The highest version of Vulkan that the device has, such as "1.3.230".
  const char *api;
  /// "discrete GPU", "integrated GPU", "virtual GPU", "CPU" or "other".
  const char *kind;
} SsctDeviceInfo;

/// A method, and a line that describes it.
typedef struct SsctMethod {
  /// The method's name, as in `SsctReflectionsInfo.method`.
  const char *name;
  /// What the method does.
  const char *summary;
} SsctMethod;

/// How you use an image before or after the library's commands: its layout, and the pipeline stages and accesses of
/// your use. A struct of zeros means SSCT_USE_FRAGMENT_SAMPLED.
typedef struct SsctImageUse {
  /// The image's layout.
  VkImageLayout layout;
  /// Pipeline stages that use the image.
  VkPipelineStageFlags2 stages;
  /// How these stages access the image.
  VkAccessFlags2 access;
} SsctImageUse;

/// A common use of an image: one of SSCT_USE_*.
typedef uint32_t SsctUse;

/// A parameter of a method and its value, such as { "fade", "off" }; docs/options.md lists all parameters. "preset" is
/// a parameter, too.
typedef struct SsctParameter {
  /// The parameter's name.
  const char *name;
  /// The parameter's value as text.
  const char *value;
} SsctParameter;

/// The images that are produced: SSCT_OUTPUT_*, combined by `|`.
typedef uint32_t SsctOutputs;

/// The projection of a camera: one of SSCT_PROJECTION_*.
typedef uint32_t SsctProjection;

/// The description of reflections that are to be made: size, method, inputs and outputs.
typedef struct SsctReflectionsInfo {
  /// sizeof(SsctReflectionsInfo).
  size_t struct_size;
  /// Width and height of the view in pixels.
  VkExtent2D extent;
  /// A method of `ssct_methods`; NULL for "unified".
  const char *method;
  /// Parameters of the method. A parameter that is not given has its published value.
  const struct SsctParameter *parameters;
  /// Number of parameters.
  uint32_t parameter_count;
  /// Width and height of the faces of the capture cubes that every frame is given; 0 for frames without captures.
  uint32_t capture_side;
  /// The images that are produced; 0 for composite and reflection.
  SsctOutputs outputs;
  /// Number of frames that may be under way at once; 0 for 2.
  uint32_t frames_in_flight;
  /// Triangles that are made like those of every later frame; NULL for frames without triangles. Reflections have
  /// captures or triangles, and not both.
  const struct SsctTriangles *triangles;
  /// The projection of every frame's camera.
  SsctProjection projection;
} SsctReflectionsInfo;

/// The place of an image's top in clip space: one of SSCT_CLIP_Y_*.
typedef uint32_t SsctClipY;

/// The camera of a frame, in your conventions. The library finds in the matrices whether space is left-handed, whether
/// y is up, whether depth is reversed, where the far plane is, and how far a jittered projection is shifted. A matrix
/// is 16 numbers, column by column, and is multiplied by column vectors from the right.
typedef struct SsctCamera {
  /// sizeof(SsctCamera).
  size_t struct_size;
  /// World to view space: a rotation and a translation.
  float world_to_view[16];
  /// View to clip space: a perspective or an orthographic projection, with the jitter that the images were drawn with. An
  /// orthographic projection has its near plane at the eye or in front of the eye.
  float view_to_clip[16];
  /// The place of the image's top in clip space.
  SsctClipY clip_y;
} SsctCamera;

/// An image of yours. The library reads one level and one layer of the image, or six layers of a cube map.
typedef struct SsctImage {
  /// sizeof(SsctImage).
  size_t struct_size;
  /// The image.
  VkImage image;
  /// A view of the part that is read. The view of a depth image shows the depth alone; the view of a cube map is an array of the
  /// six faces.
  VkImageView view;
  /// The image's format.
  VkFormat format;
  /// Width and height of the part in texels.
  VkExtent2D extent;
  /// The part that the view shows, with every aspect that a barrier of the image's format needs. Aspects of 0 stand for all
  /// aspects of the format. A count of 0 stands for one level, for one layer, or for the six layers of a cube map.
  VkImageSubresourceRange part;
  /// The usage that the image was made with: VK_IMAGE_USAGE_SAMPLED_BIT must be in it, or VK_IMAGE_USAGE_STORAGE_BIT for numbers
  /// of triangles. 0 stands for both bits.
  VkImageUsageFlags usage;
  /// How you used the image last.
  struct SsctImageUse before;
  /// How you use the image next. The recorded commands leave the image in the layout of that use.
  struct SsctImageUse after;
} SsctImage;

/// The space of normals: one of SSCT_NORMAL_SPACE_*.
typedef uint32_t SsctNormalSpace;

/// How texels hold unit normals: one of SSCT_NORMAL_ENCODING_*.
typedef uint32_t SsctNormalEncoding;

/// The normals of your G-buffer.
typedef struct SsctNormals {
  /// sizeof(SsctNormals).
  size_t struct_size;
  /// The image of the normals.
  const struct SsctImage *image;
  /// The space of the normals.
  SsctNormalSpace space;
  /// How texels hold the normals.
  SsctNormalEncoding encoding;
} SsctNormals;

/// Reflectivity or roughness of a frame: a channel of an image, or one value.
typedef struct SsctFactor {
  /// sizeof(SsctFactor).
  size_t struct_size;
  /// The image; NULL for one value.
  const struct SsctImage *image;
  /// The image's channel, 0 to 3 for red to alpha.
  uint32_t channel;
  /// The value for the whole frame, 0 to 1; read only if `image` is NULL.
  float value;
} SsctFactor;

/// The kinds of reflecting surface that a frame may have, which you know from the materials that you drew:
/// SSCT_REFLECTORS_*, combined by `|`. The passes for a kind that is absent are left out.
typedef uint32_t SsctReflectors;

/// The motion of each pixel: the way over the screen from where its surface is to where the surface was in the frame before, x in
/// red and y in green.
typedef struct SsctMotion {
  /// sizeof(SsctMotion).
  size_t struct_size;
  /// The image of the motion, in floats or signed normalised numbers.
  const struct SsctImage *image;
  /// How many pixels one unit of the motion is, x to the right and y down. Give 1 and 1 if the motion is in pixels,
  /// and the image's width and height if the motion is in texture coordinates. Negate the second number if y points
  /// up. Negate both numbers if the motion leads from the frame before to this one.
  float scale[2];
  /// Whether the motion contains the difference of the two frames' jitter. Motion does if it was computed with the
  /// jittered matrices that the images were drawn with.
  VkBool32 jittered;
} SsctMotion;

/// The inputs of a frame.
typedef struct SsctFrame {
  /// sizeof(SsctFrame).
  size_t struct_size;
  /// The number of this frame among the frames under way, below `SsctReflectionsInfo.frames_in_flight`. The device must be done
  /// with the frame that was recorded with the same number before.
  uint32_t slot;
  /// Whether each pass is timed (`ssct_reflections_times`). The passes of a timed frame do not overlap.
  VkBool32 timed;
  /// The camera that the images were drawn with.
  const struct SsctCamera *camera;
  /// Depth: a depth image, or a colour image with depth in red.
  const struct SsctImage *depth;
  /// Normals.
  const struct SsctNormals *normals;
  /// The share of the light that is reflected.
  const struct SsctFactor *reflectivity;
  /// Roughness; 0 is a mirror.
  const struct SsctFactor *roughness;
  /// Lit colour, linear, without reflections.
  const struct SsctImage *color;
  /// A cube map of the sky's light, in world axes. Its view is an array of the six faces
  /// (VK_IMAGE_VIEW_TYPE_2D_ARRAY). A ray gets this light if captures or triangles say that the ray ends in the sky.
  /// With NULL such rays miss. Without captures and triangles, every ray that leaves the screen misses.
  const struct SsctImage *sky;
  /// Images of the scene around places, for rays that the screen loses; NULL where `capture_side` is 0.
  const struct SsctCaptureCubes *captures;
  /// Triangles of the scene, for rays that the screen loses; NULL where `SsctReflectionsInfo.triangles` is NULL.
  const struct SsctTriangles *triangles;
  /// The number of the triangle that each pixel shows, counted over all meshes in their order, or UINT32_MAX for
  /// none. The image is R32_UINT, made with VK_IMAGE_USAGE_STORAGE_BIT. With NULL, some rays hit the very surface
  /// that they start from.
  const struct SsctImage *triangle_numbers;
  /// The kinds of reflecting surface that the frame may have.
  SsctReflectors reflectors;
  /// How you use the outputs next.
  struct SsctImageUse outputs;
  /// The motion of surfaces since the frame that was recorded before, for the parameter "history"; NULL if the motion
  /// is not known, or if nothing but the camera moved.
  const struct SsctMotion *motion;
} SsctFrame;

/// An image that the library made and owns. The handle stays the same in every frame, until the reflections are resized
/// or destroyed. The image can be sampled, and copied from.
typedef struct SsctOutputImage {
  /// The image; VK_NULL_HANDLE if there is none.
  VkImage image;
  /// A view of the image's first level.
  VkImageView view;
  /// The image's format.
  VkFormat format;
  /// Width and height in pixels.
  VkExtent2D extent;
} SsctOutputImage;

/// A pass that a frame leaves out.
typedef struct SsctSkipped {
  /// The pass's label.
  const char *pass;
  /// The reason, in a clause.
  const char *why;
} SsctSkipped;

/// The outputs and passes of a recorded frame. Texts and arrays stay until the next frame of the same reflections is recorded, or
/// the reflections are destroyed.
typedef struct SsctRecorded {
  /// sizeof(SsctRecorded).
  size_t struct_size;
  /// Lit colour plus reflections, linear, R16G16B16A16_SFLOAT. There is no such image if
  /// `SsctReflectionsInfo.outputs` leaves it out.
  struct SsctOutputImage composite;
  /// The reflection in rgb, before reflectivity, and its fade in alpha: 0 where the method has no reflection, less
  /// than 1 where the reflection fades out. R16G16B16A16_SFLOAT. There is no such image if
  /// `SsctReflectionsInfo.outputs` leaves it out, or if nothing reflects.
  struct SsctOutputImage reflection;
  /// The place where each ray ended: texture coordinates, standard depth, and a code that says how the ray ended
  /// (`PATH_*` of shaders-glsl/common/constants.glsl). R32G32B32A32_SFLOAT. There is no such image if
  /// `SsctReflectionsInfo.outputs` leaves it out, or if the method does not tell where rays end.
  struct SsctOutputImage hits;
  /// The passes that were recorded, in order.
  const char *const *passes;
  /// Number of passes.
  uint32_t pass_count;
  /// Number of passes that this frame leaves out.
  uint32_t skipped_count;
  /// The passes that this frame leaves out, and why.
  const struct SsctSkipped *skipped;
} SsctRecorded;

/// How long a pass took.
typedef struct SsctPassTime {
  /// The pass's label; a level of a chain follows a slash, as in "hi-z/3".
  const char *name;
  /// Milliseconds that the pass took.
  double ms;
  /// Milliseconds from the frame's first timestamp to the first timestamp of the pass.
  double start_ms;
  /// Whether the pass counts towards the method's total.
  bool counted;
} SsctPassTime;

/// The description of capture cubes that are to be made.
typedef struct SsctCaptureCubesInfo {
  /// sizeof(SsctCaptureCubesInfo).
  size_t struct_size;
  /// The places of the captures in world space: x, y and z of each place, one after the other.
  const float *places;
  /// Number of places, 1 to 8.
  uint32_t place_count;
  /// Width and height of each face in texels, 1 to 4096.
  uint32_t side;
  /// The projection that all faces were drawn with. Its angle of view is a quarter turn, and its numbers have the
  /// order of those of `SsctCamera.view_to_clip`.
  float view_to_clip[16];
  /// The place of the top of a face in clip space: one of SSCT_CLIP_Y_*.
  SsctClipY clip_y;
  /// How many frames that renew faces may be under way at once, 1 to 64; 0 stands for 2.
  uint32_t frames_in_flight;
  /// A box in world space outside of which nothing stands, so that rays that leave it end in the sky: six numbers, the least
  /// corner and then the greatest. NULL if there is no such box.
  const float *bounds;
} SsctCaptureCubesInfo;

/// A face of a capture.
typedef struct SsctCaptureFace {
  /// sizeof(SsctCaptureFace).
  size_t struct_size;
  /// The capture's number, from 0.
  uint32_t capture;
  /// The face's number, 0 to 5: +x -x +y -y +z -z. Each face is turned as in a cube map of Vulkan whose directions
  /// are world directions.
  uint32_t face;
  /// The colour of the surfaces in the face, linear, in light that does not depend on the viewer.
  const struct SsctImage *color;
  /// The depth of the face.
  const struct SsctImage *depth;
} SsctCaptureFace;

/// A mesh, where it stands, and the light that comes from it in reflections. The library keeps no pointer to the
/// struct. Set the struct to zero before you fill it in, so that the mesh has no texture unless you give it one.
typedef struct SsctTriangleMesh {
  /// Places of the vertices, in the mesh's own space: x, y and z of each vertex, one vertex after the other.
  const float *positions;
  /// Three indices of vertices for each triangle. Triangles are seen from both sides.
  const uint32_t *indices;
  /// Number of vertices.
  uint32_t vertex_count;
  /// Number of indices.
  uint32_t index_count;
  /// The matrix from the mesh's space to the world, column by column.
  float mesh_to_world[16];
  /// The light that comes from the mesh, linear. Give the colour of the mesh as your lights make it, since the
  /// library does not light meshes. With a texture, the colour is a factor of the texture.
  float color[3];
  /// The number of the mesh's texture among those of `ssct_triangles_create_textured`; read only with `texture_places`.
  uint32_t texture;
  /// The texture coordinates of each vertex, two numbers each: (0, 0) is the corner of the first texel, (1, 1) that
  /// of the last. Outside of this range the texture repeats. NULL for a mesh without a texture.
  const float *texture_places;
} SsctTriangleMesh;

/// A texture of the light that comes from meshes. Rays interpolate between four texels of the mip level whose texels are nearest in
/// size to the ray's footprint. The library makes the levels, and keeps no pointer to the struct.
typedef struct SsctHitTexture {
  /// Four bytes for each texel: red, green, blue, and a byte that is not read. Rows begin at the top.
  const uint8_t *texels;
  /// Width in texels, 1 to 32768.
  uint32_t width;
  /// Height in texels, 1 to 32768.
  uint32_t height;
  /// Whether the bytes are sRGB; otherwise they are linear.
  VkBool32 is_srgb;
} SsctHitTexture;

/// The image's top is at y = -w, as in Vulkan with a viewport of positive height.
#define SSCT_CLIP_Y_DOWN 0

/// The image's top is at y = w: the viewport has a negative height.
#define SSCT_CLIP_Y_UP 1

/// Your view space.
#define SSCT_NORMAL_SPACE_VIEW 0

/// Your world space.
#define SSCT_NORMAL_SPACE_WORLD 1

/// A texel holds x, y and z without a mapping, in floats or signed normalised numbers.
#define SSCT_NORMAL_ENCODING_FLOAT 0

/// A texel holds x, y and z, each mapped from the range -1 to 1 into the range 0 to 1.
#define SSCT_NORMAL_ENCODING_UNORM 1

/// A texel holds two numbers from -1 to 1: the place on an octahedron that is unfolded to a square.
#define SSCT_NORMAL_ENCODING_OCTAHEDRAL 2

/// A texel holds the place on the octahedron, with both numbers mapped into the range 0 to 1.
#define SSCT_NORMAL_ENCODING_OCTAHEDRAL_UNORM 3

/// Sampled in fragment shaders, in SHADER_READ_ONLY_OPTIMAL.
#define SSCT_USE_FRAGMENT_SAMPLED 0

/// Sampled in compute shaders, in SHADER_READ_ONLY_OPTIMAL.
#define SSCT_USE_COMPUTE_SAMPLED 1

/// Drawn into as a colour attachment.
#define SSCT_USE_COLOR_ATTACHMENT 2

/// Drawn into as a depth attachment; the layout is for the depth aspect alone.
#define SSCT_USE_DEPTH_ATTACHMENT 3

/// Copied or blitted from.
#define SSCT_USE_TRANSFER_SOURCE 4

/// Copied or blitted to, or cleared.
#define SSCT_USE_TRANSFER_TARGET 5

/// Lit colour plus reflections.
#define SSCT_OUTPUT_COMPOSITE 1

/// The reflection alone, for a renderer that adds it up itself.
#define SSCT_OUTPUT_REFLECTION 2

/// The place where each ray ended, if the method can say it.
#define SSCT_OUTPUT_HITS 4

/// You do not know the kinds, and the frame may have every kind. This flag is right for every frame.
#define SSCT_REFLECTORS_UNKNOWN 0

/// There may be mirrors: surfaces that reflect with roughness 0.
#define SSCT_REFLECTORS_MIRRORS 1

/// There may be surfaces with narrow lobes: roughness above 0, up to 0.2f.
#define SSCT_REFLECTORS_NARROW 2

/// There may be surfaces with wide lobes: roughness above 0.2f.
#define SSCT_REFLECTORS_WIDE 4

/// Every lit surface reflects, so that every pixel reflects except those that show the sky.
#define SSCT_REFLECTORS_EVERYWHERE 8

/// Nothing reflects. This flag stands alone, and is not combined with others.
#define SSCT_REFLECTORS_NONE 16

/// All rays of sight leave from the eye.
#define SSCT_PROJECTION_PERSPECTIVE 0

/// All rays of sight are parallel.
#define SSCT_PROJECTION_ORTHOGRAPHIC 1

/// Memory on the device.
#define SSCT_MEMORY_PLACE_DEVICE 0

/// Memory that the host writes and the device reads; mapped and coherent.
#define SSCT_MEMORY_PLACE_UPLOAD 1

/// Memory that the device writes and the host reads; mapped and coherent.
#define SSCT_MEMORY_PLACE_READBACK 2

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Returns the sentence, in UTF-8, on the last call of this thread that failed: what is wrong, and where. The sentence is empty
/// before any call has failed, and stays until the next call of this thread fails.
const char *ssct_last_error(void);

/// Returns the version of the library, such as "0.1.0".
const char *ssct_version(void);

/// Turns on the features that this library needs in the three structs, and leaves other features as they are. All of
/// them are features of core Vulkan 1.3, so that no extension is needed. Some devices lack `largePoints`: turn this
/// feature off there, and only the method "unified" cannot be made. Set `sType` of the last two structs before the
/// call.
enum SsctResult ssct_enable_features(VkPhysicalDeviceFeatures *features,
                                     VkPhysicalDeviceVulkan12Features *features12,
                                     VkPhysicalDeviceVulkan13Features *features13);

/// Makes a context of your device, and writes the new context to `context`, or NULL if the call fails.
enum SsctResult ssct_context_create(const struct SsctContextInfo *info, struct SsctContext **context);

/// Destroys a context; NULL is allowed. Objects that were made with the context stay usable, and keep what they need.
void ssct_context_destroy(struct SsctContext *context);

/// Writes name, driver, version and kind of the device to `info`, whose `struct_size` is set.
enum SsctResult ssct_context_device_info(const struct SsctContext *context, struct SsctDeviceInfo *info);

/// Returns true if passes can be timed, which needs a queue family with timestamps.
bool ssct_context_has_timestamps(const struct SsctContext *context);

/// Returns how many bytes of device memory the library has allocated with the context; 0 if the context has an
/// allocator of yours.
uint64_t ssct_context_allocated_bytes(const struct SsctContext *context);

/// Destroys the pipelines that no object uses now. Without this call such pipelines are kept, so that an object that is
/// made or resized later compiles nothing twice.
void ssct_context_trim(const struct SsctContext *context);

/// Returns an array of the methods that need no scene, and writes its length to `count`. All these methods need a
/// G-buffer; "captures" also needs capture cubes, and "traced" also needs triangles. The array stays for as long as the
/// library is loaded.
const struct SsctMethod *ssct_methods(uint32_t *count);

/// Returns layout, stages and accesses of a common use of an image; a struct of zeros for a number that is none of
/// SSCT_USE_*.
struct SsctImageUse ssct_image_use(SsctUse kind);

/// Makes all that the frames of a view need, and writes the new object to `reflections`, or NULL if the call fails.
/// Nothing is submitted.
enum SsctResult ssct_reflections_create(const struct SsctContext *context,
                                        const struct SsctReflectionsInfo *info,
                                        struct SsctReflections **reflections);

/// Destroys reflections; NULL is allowed. The device must be done with every frame that was recorded.
void ssct_reflections_destroy(struct SsctReflections *reflections);

/// Makes images of another size. The device must be done with every frame that was recorded. If the call fails, the old size stays.
enum SsctResult ssct_reflections_resize(struct SsctReflections *reflections,
                                        VkExtent2D extent);

/// Forgets the frames that the parameter "history" averages, so that the next frame stands alone. Call it after a cut, and after a
/// command buffer was thrown away.
enum SsctResult ssct_reflections_restart_history(struct SsctReflections *reflections);

/// Records a frame's reflections into a command buffer. The call submits nothing and does not wait. After one frame in
/// every slot, the call allocates nothing on the device. The call writes the frame's outputs and passes to `recorded`,
/// whose `struct_size` you set; `recorded` may be NULL. If the result is SSCT_RESULT_USAGE, nothing is recorded. After
/// another failure, throw the command buffer away.
///
/// - The command buffer is recording, outside rendering, for a queue of the context's family.
/// - The handles of the inputs belong to the context's device, are as their fields describe them, and live until the
///   device is done. The commands that write the images were submitted before.
/// - The frame that was recorded with the same slot before is no longer under way.
/// - Frames of one object are submitted in the order in which they were recorded, to one queue. The faces of the
///   captures that they see are submitted to the same queue, in order. A command buffer is submitted once, or thrown
///   away before another is recorded.
enum SsctResult ssct_reflections_record(struct SsctReflections *reflections,
                                        VkCommandBuffer commands,
                                        const struct SsctFrame *frame,
                                        struct SsctRecorded *recorded);

/// Writes to `times` an array of how long each pass of the last frame of a slot took, and to `count` the array's
/// length, which is 0 if the frame was not timed. The result is SSCT_RESULT_NOT_READY if the device is not done with
/// the frame yet. The array stays until the next call of this function, or until the reflections are destroyed.
enum SsctResult ssct_reflections_times(struct SsctReflections *reflections,
                                       uint32_t slot,
                                       const struct SsctPassTime **times,
                                       uint32_t *count);

/// Makes the images of captures, which have no content yet, and writes the new object to `cubes`, or NULL if the call
/// fails.
enum SsctResult ssct_capture_cubes_create(const struct SsctContext *context,
                                          const struct SsctCaptureCubesInfo *info,
                                          struct SsctCaptureCubes **cubes);

/// Destroys captures; NULL is allowed. The device must be done with every frame that saw the captures.
void ssct_capture_cubes_destroy(struct SsctCaptureCubes *cubes);

/// Records the commands that copy a face into the captures. Submit the commands before frames that are to see the face.
/// `slot` is the number of this frame among the frames under way, below `SsctCaptureCubesInfo.frames_in_flight`. If the
/// result is SSCT_RESULT_USAGE, nothing is recorded.
enum SsctResult ssct_capture_cubes_record_face(struct SsctCaptureCubes *cubes,
                                               VkCommandBuffer commands,
                                               uint32_t slot,
                                               const struct SsctCaptureFace *face);

/// Builds the tree over the triangles of meshes on the CPU, makes the buffers, and writes the object to `triangles`; NULL if the
/// call fails. `ssct_triangles_record_upload` fills the buffers.
enum SsctResult ssct_triangles_create(const struct SsctContext *context,
                                      const struct SsctTriangleMesh *meshes,
                                      uint32_t mesh_count,
                                      struct SsctTriangles **triangles);

/// Does the same as `ssct_triangles_create`, for meshes with textures.
enum SsctResult ssct_triangles_create_textured(const struct SsctContext *context,
                                               const struct SsctTriangleMesh *meshes,
                                               uint32_t mesh_count,
                                               const struct SsctHitTexture *textures,
                                               uint32_t texture_count,
                                               struct SsctTriangles **triangles);

/// Destroys triangles; NULL is allowed. The device must be done with every frame that saw the triangles.
void ssct_triangles_destroy(struct SsctTriangles *triangles);

/// Records the copy of the triangles to the device. Call it once, before the first frame that sees them.
enum SsctResult ssct_triangles_record_upload(struct SsctTriangles *triangles, VkCommandBuffer commands);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SSCT_H */
