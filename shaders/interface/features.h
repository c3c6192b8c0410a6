// Scene features (host/scene/features.cpp): a clear bit compiles the code it names away.
#ifndef REGULUS_INTERFACE_FEATURES_H
#define REGULUS_INTERFACE_FEATURES_H

#include "types.h"

REGULUS_INTERFACE_BEGIN

REGULUS_CONSTANT FEATURE_TEXTURES = 1u;            // any texture that shading reads
REGULUS_CONSTANT FEATURE_TRIANGLE_LIGHTS = 2u;
REGULUS_CONSTANT FEATURE_POINT_LIGHTS = 4u;        // point or spot
REGULUS_CONSTANT FEATURE_DIRECTIONAL_LIGHTS = 8u;
REGULUS_CONSTANT FEATURE_ROUGH_SPECULAR = 16u;     // some microfacet lobe has alpha > 0
REGULUS_CONSTANT FEATURE_DELTA_SPECULAR = 32u;     // some microfacet lobe has alpha == 0
REGULUS_CONSTANT FEATURE_ABSORPTION = 64u;         // some volume attenuates
REGULUS_CONSTANT FEATURE_MANY_LIGHTS = 128u;       // more than one light: the alias table is read
REGULUS_CONSTANT FEATURE_SMOOTH_NORMALS = 256u;    // some triangle's normals differ from its geometric normal
REGULUS_CONSTANT FEATURE_TWO_SIDED_LIGHTS = 512u;  // some emissive triangle emits from both faces
REGULUS_CONSTANT FEATURE_CLIPPING = 1u << 12;      // some camera has a clipping plane that hides something
REGULUS_CONSTANT FEATURE_LIGHT_RANGES = 1u << 13;  // some point or spot light ends at a distance; implies POINT_LIGHTS
REGULUS_CONSTANT FEATURE_SHEEN = 1u << 14;         // some material has sheen
REGULUS_CONSTANT FEATURE_IRIDESCENCE = 1u << 15;   // some material has a thin film
REGULUS_CONSTANT FEATURE_VERTEX_COLORS = 1u << 16;  // some vertex has a colour
REGULUS_CONSTANT FEATURE_NORMAL_MAPS = 1u << 17;    // some material has a normal map; implies SMOOTH_NORMALS, TEXTURES
REGULUS_CONSTANT FEATURE_ENVIRONMENT = 1024u;      // light from all directions
REGULUS_CONSTANT FEATURE_ENVIRONMENT_MAP = 2048u;  // that differs between them
REGULUS_CONSTANT FEATURE_ALPHA = 1u << 18;          // some surface is masked or blended
REGULUS_CONSTANT FEATURE_CLEARCOAT = 1u << 19;      // some material has a clearcoat
REGULUS_CONSTANT FEATURE_ANISOTROPY = 1u << 20;     // some material is anisotropic
REGULUS_CONSTANT FEATURE_TEXTURE_MAPPINGS = 1u << 21;   // some texture is TEXTURE_MAPPED
REGULUS_CONSTANT FEATURE_UV_SETS = 1u << 22;            // some texture reads further coordinates of the vertices
REGULUS_CONSTANT FEATURE_SPECULAR_TEXTURES = 1u << 23;  // some material's specular reflection is textured
REGULUS_CONSTANT FEATURE_WIDE_TEXELS = 1u << 30;        // some texture is TEXTURE_UNORM16 or TEXTURE_HALF
REGULUS_CONSTANT FEATURE_INSTANCES = 1u << 24;          // some mesh is stored once for several copies
REGULUS_CONSTANT FEATURE_COAT_NORMALS = 1u << 25;       // some material has MATERIAL_COAT_NORMAL; implies CLEARCOAT
REGULUS_CONSTANT FEATURE_BULGES = 1u << 27;             // some triangle's vertex normals spread: it stands for a curved surface
REGULUS_CONSTANT FEATURE_ROUGH_BASE = 1u << 26;         // some diffuse base lies under a rough dielectric interface
REGULUS_CONSTANT FEATURE_DISPERSION = 1u << 29;         // some solid's index of refraction depends on the wavelength
REGULUS_CONSTANT FEATURE_CONTACTS = 1u << 28;           // solids nest, touch or hold a camera or a light; surfaces coincide

REGULUS_INTERFACE_END

#endif
