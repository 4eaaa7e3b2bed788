using System;
using System.Collections.Generic;
using UnityEngine.Rendering;

namespace UnityEngine.Rendering
{
    public enum ShadowCastingMode
    {
        Off,
        On,
    }
}

namespace UnityEngine
{
    public class Time
    {
        public static float deltaTime { get; internal set; }
        public static float unscaledDeltaTime { get; internal set; }
        public static float realtimeSinceStartup { get; internal set; }
        public static int frameCount { get; internal set; }
        public static float timeScale { get; set; } = 1;
    }

    public class Application
    {
        public static bool isMobilePlatform { get; internal set; }
        public static bool isEditor { get; internal set; }
        public static bool isPlaying { get; internal set; } = true;
        public static string version { get; internal set; } = "1.0";
        public static string streamingAssetsPath { get; internal set; } = "";
        public static string persistentDataPath { get; internal set; } = System.IO.Path.GetTempPath();

        public static event Action quitting;

        /// <summary>For tests: the address that was opened last.</summary>
        internal static string OpenedUrl { get; private set; } = "";

        public static void OpenURL(string url) => OpenedUrl = url;

        /// <summary>For tests: ends the player.</summary>
        internal static void SayQuitting() => quitting?.Invoke();
    }

    public sealed class SystemInfo
    {
        public static string deviceModel => "PC";
        public static string processorType => "CPU";
        public static int processorCount => 2;
    }

    public static class JsonUtility
    {
        /// <summary>A text that differs if a public field differs. It is not JSON, which no test reads.</summary>
        public static string ToJson(object obj)
        {
            if (obj == null || obj is IConvertible)
                return FormattableString.Invariant($"{obj};");
            if (obj is Array items)
                return string.Concat(System.Linq.Enumerable.Select(System.Linq.Enumerable.Cast<object>(items), ToJson)) + "]";
            return obj.GetType().Name + string.Concat(System.Linq.Enumerable.Select(obj.GetType().GetFields(), field => field.IsStatic ? "" : ToJson(field.GetValue(obj))));
        }
    }

    public class Debug
    {
        /// <summary>For tests: the logged lines.</summary>
        internal static List<string> Lines { get; } = new List<string>();

        public static void Log(object message, Object context) => Lines.Add("log: " + message);
        public static void LogWarning(object message, Object context) => Lines.Add("warning: " + message);
        public static void LogError(object message, Object context) => Lines.Add("error: " + message);
        public static void LogException(Exception exception, Object context) => Lines.Add("exception: " + exception.Message);
    }

    public class Physics
    {
        private static readonly HashSet<(int, int)> Ignored = new HashSet<(int, int)>();
        private static readonly HashSet<(Collider, Collider)> IgnoredPairs = new HashSet<(Collider, Collider)>();

        internal static List<Collider> Colliders { get; } = new List<Collider>();

        /// <summary>For tests: the calls of SyncTransforms and reads of bounds.</summary>
        internal static int SlowCallCount { get; set; }

        /// <summary>Updates the bounds of colliders, which do not follow the transforms before this call.</summary>
        public static void SyncTransforms()
        {
            ++SlowCallCount;
            for (int index = 0; index < Colliders.Count; ++index)
                Colliders[index].Position = Colliders[index].transform.position;
        }

        public static bool GetIgnoreCollision(Collider collider1, Collider collider2)
        {
            if (collider1 == null || collider2 == null)
                throw new ArgumentNullException(collider1 == null ? nameof(collider1) : nameof(collider2));
            return IgnoredPairs.Contains((collider1, collider2));
        }

        public static void IgnoreCollision(Collider collider1, Collider collider2, bool ignore)
        {
            foreach ((Collider, Collider) pair in new[] { (collider1, collider2), (collider2, collider1) })
            {
                if (ignore)
                    IgnoredPairs.Add(pair);
                else
                    IgnoredPairs.Remove(pair);
            }
        }

        public static bool GetIgnoreLayerCollision(int layer1, int layer2) => Ignored.Contains((layer1, layer2));

        public static void IgnoreLayerCollision(int layer1, int layer2, bool ignore)
        {
            foreach ((int, int) pair in new[] { (layer1, layer2), (layer2, layer1) })
            {
                if (ignore)
                    Ignored.Add(pair);
                else
                    Ignored.Remove(pair);
            }
        }
    }

    public class Collider : Component
    {
        public bool enabled { get; set; } = true;
        public bool isTrigger { get; set; }
        public Bounds bounds
        {
            get
            {
                ++Physics.SlowCallCount;
                return enabled && gameObject.activeInHierarchy ? new Bounds(Position, Size) : default;
            }
        }

        internal Vector3 Position { get; set; }
        internal virtual Vector3 Size => Vector3.one;

        internal override void OnDestroyed() => Physics.Colliders.Remove(this);
    }

    public class BoxCollider : Collider
    {
        public Vector3 center { get; set; }
        public Vector3 size { get; set; } = Vector3.one;
        internal override Vector3 Size => size;
    }

    public class SphereCollider : Collider
    {
        public Vector3 center { get; set; }
        public float radius { get; set; } = 0.5f;
    }

    public class CapsuleCollider : Collider
    {
        public Vector3 center { get; set; }
        public float radius { get; set; } = 0.5f;
        public float height { get; set; } = 2;
        public int direction { get; set; } = 1;
    }

    public class CharacterController : Collider
    {
        public float radius { get; set; } = 0.5f;
        public float height { get; set; } = 2;
        public Vector3 center { get; set; }
    }

    public class MeshCollider : Collider
    {
        public Mesh sharedMesh { get; set; }
    }

    public sealed class Mesh : Object
    {
        public Bounds bounds { get; set; }
    }

    public sealed class MeshFilter : Component
    {
        public Mesh sharedMesh { get; set; }
    }

    public class Renderer : Component
    {
        public Material sharedMaterial { get; set; } = new Material((Material)null);
        public Material material => sharedMaterial;
    }

    public class MeshRenderer : Renderer
    {
    }

    public class Material : Object
    {
        public Material(Material source)
        {
        }

        public bool enableInstancing { get; set; }

        public void SetColor(string name, Color value)
        {
        }
    }

    public struct RenderParams
    {
        public RenderParams(Material mat)
        {
            material = mat;
            shadowCastingMode = ShadowCastingMode.On;
        }

        public Material material { get; set; }
        public ShadowCastingMode shadowCastingMode { get; set; }
    }

    public class Graphics
    {
        /// <summary>For tests: the number of instances drawn.</summary>
        internal static int InstanceCount { get; set; }

        public static void RenderMeshInstanced<T>(in RenderParams rparams, Mesh mesh, int submeshIndex, T[] instanceData, int instanceCount = -1, int startInstance = 0)
            where T : unmanaged
        {
            if (instanceCount < 1 || startInstance + instanceCount > instanceData.Length || !rparams.material.enableInstancing)
                throw new ArgumentException("Unity refuses this.");
            InstanceCount += instanceCount;
        }
    }

    public sealed class Gizmos
    {
        public static Color color { get; set; }

        public static void DrawWireCube(Vector3 center, Vector3 size)
        {
        }
    }

    public sealed class Screen
    {
        public static int width => 1280;
        public static int height => 720;
    }

    public sealed class QualitySettings : Object
    {
        internal QualitySettings()
        {
        }

        public static int vSyncCount { get; set; }
    }

    public class TextAsset : Object
    {
        public byte[] bytes { get; internal set; } = Array.Empty<byte>();
    }
}
