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

        /// <param name="layers">The layers that may form pairs. All other layers get a filter that matches nothing.</param>
        /// <param name="usesMatrix">False: all of these layers collide with each other.</param>
        internal void Read(LayerMask layers, bool usesMatrix)
        {
            uint tracked = unchecked((uint)layers.value);
            for (int layer = 0; layer < LayerCount; ++layer)
            {
                bool isTracked = (tracked >> layer & 1) != 0;
                filters[layer] = isTracked ? new ProxyFilter(1u << layer, tracked & MaskOf(layer, usesMatrix)) : default;
            }
        }

        internal ProxyFilter Of(int layer) => filters[layer];

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
