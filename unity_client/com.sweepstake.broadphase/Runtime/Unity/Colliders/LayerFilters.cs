#nullable enable
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>
    /// Unity's layers as proxy filters: the category of a layer is the layer's bit, and the mask contains the layers that it collides with.
    /// </summary>
    internal sealed class LayerFilters
    {
        private const int LayerCount = 32;
        private readonly ProxyFilter[] filters = new ProxyFilter[LayerCount];
        private uint statics;

        /// <param name="layers">The layers that may form pairs. Queries find the colliders of all layers.</param>
        /// <param name="staticLayers">The layers of colliders that do not move.</param>
        /// <param name="usesMatrix">False: all layers in `layers` collide with each other.</param>
        internal void Read(LayerMask layers, LayerMask staticLayers, bool usesMatrix)
        {
            uint paired = unchecked((uint)layers.value);
            statics = unchecked((uint)staticLayers.value);
            for (int layer = 0; layer < LayerCount; ++layer)
            {
                uint mask = (paired >> layer & 1) == 0 ? 0 : paired & MaskOf(layer, usesMatrix);
                // A query finds nothing whose mask is empty. The next layer in the mask of a layer that collides with nothing changes no pair,
                // because a pair needs both masks, and no mask contains this layer.
                filters[layer] = new ProxyFilter(1u << layer, mask != 0 ? mask : 1u << (layer + 1) % LayerCount);
            }
        }

        internal ProxyFilter Of(int layer) => filters[layer];

        internal bool IsStatic(int layer) => (statics >> layer & 1) != 0;

        internal bool Collide(int layer, int other) =>
            (filters[layer].Mask & filters[other].Category) != 0 && (filters[other].Mask & filters[layer].Category) != 0;

        /// <summary>The filter of a query for these layers; the collision matrix does not matter.</summary>
        internal static ProxyFilter Query(LayerMask layers) => new ProxyFilter(uint.MaxValue, unchecked((uint)layers.value));

        private static uint MaskOf(int layer, bool usesMatrix)
        {
            uint mask = 0;
            for (int other = 0; other < LayerCount; ++other)
            {
                if (!usesMatrix || !Physics.GetIgnoreLayerCollision(layer, other))
                    mask |= 1u << other;
            }
            return mask;
        }
    }
}
