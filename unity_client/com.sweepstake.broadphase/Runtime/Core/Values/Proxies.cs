#nullable enable
using System;

namespace Sweepstake
{
    /// <summary>Handle of a proxy in a <see cref="ProxySet"/>. The handle of a removed proxy stays invalid even if its id is used again.</summary>
    public struct ProxyHandle : IEquatable<ProxyHandle>
    {
        /// <summary>The handle in the C ABI; 0 for no proxy.</summary>
        public ulong Value;

        public ProxyHandle(ulong value) => Value = value;

        public static ProxyHandle None => default;
        /// <summary>The id of the proxy in pairs while it exists.</summary>
        public readonly uint Id => (uint)Value;
        public readonly bool IsNone => Value == 0;
        /// <summary>Whether the proxy was added as static.</summary>
        public readonly bool WasAddedStatic => (Value & 0x80000000u) != 0;

        public readonly bool Equals(ProxyHandle other) => Value == other.Value;
        public override readonly bool Equals(object? other) => other is ProxyHandle handle && Equals(handle);
        public override readonly int GetHashCode() => Value.GetHashCode();
        public static bool operator ==(ProxyHandle a, ProxyHandle b) => a.Value == b.Value;
        public static bool operator !=(ProxyHandle a, ProxyHandle b) => a.Value != b.Value;
    }

    /// <summary>Two proxies can form a pair if the category of each shares a bit with the mask of the other.</summary>
    public struct ProxyFilter
    {
        public uint Category;
        public uint Mask;

        public ProxyFilter(uint category, uint mask) => (Category, Mask) = (category, mask);

        /// <summary>Matches every proxy that has a category and a mask.</summary>
        public static ProxyFilter All => new ProxyFilter(uint.MaxValue, uint.MaxValue);
    }

    [Flags]
    public enum ProxyFlags : uint
    {
        None = 0,
        /// <summary>The proxy forms pairs with moving and sleeping proxies only.</summary>
        Static = 1,
        /// <summary>The proxy sleeps. This flag is read-only; <see cref="ProxySet.SetSleeping"/> sets it.</summary>
        Sleeping = 2,
    }

    public struct ProxyOptions
    {
        /// <summary>A filter of zeros matches nothing.</summary>
        public ProxyFilter Filter;
        public ProxyFlags Flags;
        internal uint Reserved;
        /// <summary>A value that the game can use freely, such as an instance id.</summary>
        public ulong User;

        public ProxyOptions(ProxyFilter filter, ProxyFlags flags = ProxyFlags.None, ulong user = 0) =>
            (Filter, Flags, Reserved, User) = (filter, flags, 0, user);
    }

    /// <summary>Two proxies; the id of A is below that of B.</summary>
    public struct ProxyPair
    {
        public ProxyHandle A;
        public ProxyHandle B;
    }

    /// <summary>
    /// A ray: the points origin + t · direction with t from 0 to MaxDistance (in world units if the direction has length 1). All values are
    /// finite.
    /// </summary>
    public struct RayQuery
    {
        public float OriginX;
        public float OriginY;
        public float OriginZ;
        public float DirectionX;
        public float DirectionY;
        public float DirectionZ;
        public float MaxDistance;
    }

    /// <summary>A ball around the center, with a radius from 0 to 1e19. All values are finite.</summary>
    public struct SphereQuery
    {
        public float CenterX;
        public float CenterY;
        public float CenterZ;
        public float Radius;
    }

    /// <summary>A valid box that moves along the translation.</summary>
    public struct BoxSweepQuery
    {
        public Aabb Box;
        public float TranslationX;
        public float TranslationY;
        public float TranslationZ;
    }

    public struct QueryHit
    {
        /// <summary><see cref="ProxyHandle.None"/> if nothing was hit.</summary>
        public ProxyHandle Proxy;
        /// <summary>
        /// The value of t at which the ray enters the proxy's box, or the fraction of the translation at which the moving box touches it. 0
        /// if the ray or moving box starts inside.
        /// </summary>
        public float Distance;
        internal uint Reserved;
    }
}
