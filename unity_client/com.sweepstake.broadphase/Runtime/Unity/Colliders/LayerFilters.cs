#nullable enable
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>Unity's layers as filters of proxies: the category of a layer is its bit, its mask the layers that it meets.</summary>
    internal sealed class LayerFilters
    {
        private const int LayerCount = 32;
        private readonly ProxyFilter[] filters = new ProxyFilter[LayerCount];

        /// <param name="layers">Others have a filter that passes with nothing.</param>
        /// <param name="usesMatrix">False: all of these layers meet.</param>
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

        /// <summary>A query meets these layers, whatever the matrix says.</summary>
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
