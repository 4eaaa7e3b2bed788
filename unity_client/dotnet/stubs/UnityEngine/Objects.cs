// Stubs of Unity's documented API: the signatures that this package uses, with only the behaviour that the tests need.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Runtime.CompilerServices;
using UnityEngine.SceneManagement;

namespace UnityEngine
{
    [Flags]
    public enum HideFlags
    {
        None = 0,
        HideAndDontSave = 61,
    }

    public class Object
    {
        public string name { get; set; } = "";
        public HideFlags hideFlags { get; set; }
        internal bool IsDestroyed { get; private set; }

        public static bool operator ==(Object x, Object y)
        {
            if (x is null || y is null)
                return (x is null || x.IsDestroyed) && (y is null || y.IsDestroyed);
            return ReferenceEquals(x, y);
        }

        public static bool operator !=(Object x, Object y) => !(x == y);
        public static implicit operator bool(Object exists) => exists != null;
        public override bool Equals(object other) => other is Object o ? this == o : other == null && IsDestroyed;
        public override int GetHashCode() => RuntimeHelpers.GetHashCode(this);

        public static void Destroy(Object obj) => Player.Destroyed.Add(obj);

        public static void DontDestroyOnLoad(Object target) => ((GameObject)target).MoveTo(SceneManager.Lasting);

        public static void DestroyImmediate(Object obj)
        {
            if (obj is null || obj.IsDestroyed)
                return;
            obj.OnDestroyed();
            obj.IsDestroyed = true;
        }

        internal virtual void OnDestroyed()
        {
        }

        /// <summary>For tests: the game objects of all scenes with this name.</summary>
        internal static IEnumerable<GameObject> Named(string name)
        {
            var scenes = new List<Scene>(SceneManager.Loaded) { SceneManager.Lasting };
            return scenes.SelectMany(scene => scene.Content.Roots).Where(root => root.name == name);
        }
    }

    public class ScriptableObject : Object
    {
        public static T CreateInstance<T>()
            where T : ScriptableObject => (T)Activator.CreateInstance(typeof(T), true);
    }

    public class Component : Object
    {
        public GameObject gameObject { get; internal set; }
        public Transform transform => gameObject.transform;
        public string tag { get => gameObject.tag; set => gameObject.tag = value; }

        public bool CompareTag(string tag) => gameObject.CompareTag(tag);
        public T GetComponent<T>() => gameObject.GetComponent<T>();
        public void GetComponentsInChildren<T>(bool includeInactive, List<T> result) => gameObject.GetComponentsInChildren(includeInactive, result);
        public T GetComponentInParent<T>(bool includeInactive) => gameObject.GetComponentInParent<T>(includeInactive);
    }

    public class Behaviour : Component
    {
        private bool isEnabled = true;

        public bool enabled
        {
            get => isEnabled;
            set
            {
                isEnabled = value;
                Player.Sync(this);
            }
        }

        public bool isActiveAndEnabled => isEnabled && gameObject.activeInHierarchy;
        internal bool IsRunning { get; set; }
    }

    public class MonoBehaviour : Behaviour
    {
        public bool useGUILayout { get; set; } = true;
        internal bool HasStarted { get; set; }

        internal override void OnDestroyed()
        {
            Player.Stop(this);
            Player.Call(this, "OnDestroy");
            Player.Behaviours.Remove(this);
        }
    }

    public sealed class GameObject : Object
    {
        private readonly List<Component> components = new List<Component>();
        private bool isActive = true;

        public GameObject(string name)
        {
            this.name = name;
            transform = new Transform { gameObject = this };
            components.Add(transform);
            scene = SceneManager.Active;
            scene.Content.Roots.Add(this);
        }

        public GameObject(string name, params Type[] components)
            : this(name)
        {
            foreach (Type component in components)
                AddComponent(component);
        }

        public Transform transform { get; }
        public int layer { get; set; }
#if UNITY_EDITOR
        public bool isStatic { get; set; }
#endif
        public string tag { get; set; } = "Untagged";
        public Scene scene { get; private set; }
        public bool activeInHierarchy => isActive && (transform.parent == null || transform.parent.gameObject.activeInHierarchy);

        /// <summary>The tags of the project settings; tests may add more.</summary>
        internal static HashSet<string> Tags { get; } = new HashSet<string> { "Untagged", "Respawn", "Finish", "EditorOnly", "MainCamera", "Player", "GameController" };

        public bool CompareTag(string tag)
        {
            if (!Tags.Contains(tag))
                Debug.LogError($"Tag: {tag} is not defined.", this);
            return this.tag == tag;
        }

        public static GameObject CreatePrimitive(PrimitiveType type)
        {
            var made = new GameObject(type.ToString(), typeof(MeshFilter), typeof(MeshRenderer));
            made.GetComponent<MeshFilter>().sharedMesh = new Mesh();
            made.AddComponent(type == PrimitiveType.Sphere ? typeof(SphereCollider) : typeof(BoxCollider));
            return made;
        }

        public T AddComponent<T>()
            where T : Component => (T)AddComponent(typeof(T));

        public Component AddComponent(Type componentType)
        {
            foreach (RequireComponent required in componentType.GetCustomAttributes<RequireComponent>(true))
            {
                if (components.TrueForAll(component => !required.m_Type0.IsInstanceOfType(component)))
                    AddComponent(required.m_Type0);
            }
            var added = (Component)Activator.CreateInstance(componentType, true);
            added.gameObject = this;
            components.Add(added);
            if (added is MonoBehaviour behaviour)
                Player.Add(behaviour);
            if (added is Collider collider)
            {
                collider.Position = transform.position;
                Physics.Colliders.Add(collider);
            }
            return added;
        }

        public T GetComponent<T>() => components.Find(component => component is T && !component.IsDestroyed) is T found ? found : default;

        public void GetComponentsInChildren<T>(bool includeInactive, List<T> results)
        {
            results.Clear();
            Collect(includeInactive, results);
        }

        public T GetComponentInParent<T>(bool includeInactive)
        {
            for (Transform at = transform; at != null; at = at.parent)
            {
                if ((includeInactive || at.gameObject.activeInHierarchy) && at.gameObject.GetComponent<T>() is T found)
                    return found;
            }
            return default;
        }

        /// <summary>For DontDestroyOnLoad, which accepts only roots.</summary>
        internal void MoveTo(Scene other)
        {
            scene.Content.Roots.Remove(this);
            scene = other;
            scene.Content.Roots.Add(this);
        }

        public void SetActive(bool value)
        {
            isActive = value;
            SyncAll();
        }

        internal override void OnDestroyed()
        {
            foreach (Transform child in transform.Children.ToArray())
                DestroyImmediate(child.gameObject);
            foreach (Component component in components.ToArray())
                DestroyImmediate(component);
            transform.SetParent(null, false);
            scene.Content.Roots.Remove(this);
        }

        private void SyncAll()
        {
            foreach (Component component in components)
            {
                if (component is Behaviour behaviour)
                    Player.Sync(behaviour);
            }
            foreach (Transform child in transform.Children)
                child.gameObject.SyncAll();
        }

        private void Collect<T>(bool includeInactive, List<T> result)
        {
            if (!includeInactive && !activeInHierarchy)
                return;
            foreach (Component component in components)
            {
                if (component is T found)
                    result.Add(found);
            }
            foreach (Transform child in transform.Children)
                child.gameObject.Collect(includeInactive, result);
        }
    }

    public enum PrimitiveType
    {
        Sphere,
        Capsule,
        Cylinder,
        Cube,
    }

    public class Transform : Component
    {
        protected internal Transform()
        {
        }

        internal List<Transform> Children { get; } = new List<Transform>();

        public Vector3 position { get; set; }
        public Quaternion rotation { get; set; } = Quaternion.identity;
        /// <summary>In this stub a child does not move, turn or scale with its parent.</summary>
        public Vector3 localScale { get; set; } = Vector3.one;
        public Transform parent { get; private set; }

        public Matrix4x4 localToWorldMatrix
        {
            get
            {
                (Quaternion q, Vector3 s) = (rotation, localScale);
                return new Matrix4x4
                {
                    m00 = s.x * (1 - 2 * (q.y * q.y + q.z * q.z)), m01 = s.y * 2 * (q.x * q.y - q.w * q.z), m02 = s.z * 2 * (q.x * q.z + q.w * q.y),
                    m10 = s.x * 2 * (q.x * q.y + q.w * q.z), m11 = s.y * (1 - 2 * (q.x * q.x + q.z * q.z)), m12 = s.z * 2 * (q.y * q.z - q.w * q.x),
                    m20 = s.x * 2 * (q.x * q.z - q.w * q.y), m21 = s.y * 2 * (q.y * q.z + q.w * q.x), m22 = s.z * (1 - 2 * (q.x * q.x + q.y * q.y)),
                    m03 = position.x, m13 = position.y, m23 = position.z, m33 = 1,
                };
            }
        }

        public bool IsChildOf(Transform parent) => ReferenceEquals(this, parent) || (this.parent != null && this.parent.IsChildOf(parent));

        public void SetParent(Transform parent, bool worldPositionStays)
        {
            this.parent?.Children.Remove(this);
            this.parent = parent;
            parent?.Children.Add(this);
            List<GameObject> roots = gameObject.scene.Content.Roots;
            roots.Remove(gameObject);
            if (parent is null)
                roots.Add(gameObject);
        }
    }
}
