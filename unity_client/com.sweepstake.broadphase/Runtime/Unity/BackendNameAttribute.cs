#nullable enable
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>The inspector offers the names of the library's backends.</summary>
    public sealed class BackendNameAttribute : PropertyAttribute
    {
    }
}
