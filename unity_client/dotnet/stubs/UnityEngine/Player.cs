using System;
using System.Collections.Generic;
using System.Reflection;
using UnityEngine.SceneManagement;

namespace UnityEngine
{
    /// <summary>
    /// Plays the role of the engine: calls Unity's messages by name, in the order of execution. It is not part of Unity's API.
    /// </summary>
    internal static class Player
    {
        private static readonly Dictionary<(Object, string), Action> Messages = new Dictionary<(Object, string), Action>();

        internal static List<MonoBehaviour> Behaviours { get; } = new List<MonoBehaviour>();
        internal static List<Object> Destroyed { get; } = new List<Object>();

        /// <summary>Runs one frame.</summary>
        public static void Frame(float seconds = 1 / 60f)
        {
            Time.unscaledDeltaTime = seconds;
            Time.deltaTime = seconds * Time.timeScale;
            Time.realtimeSinceStartup += seconds;
            ++Time.frameCount;
            for (int index = 0; index < Behaviours.Count; ++index)
                Start(Behaviours[index]);
            CallAll("Update");
            CallAll("LateUpdate");
            foreach (Object destroyed in Destroyed)
                Object.DestroyImmediate(destroyed);
            Destroyed.Clear();
        }

        /// <summary>Sends a message to all running scripts.</summary>
        public static void Send(string message, bool value)
        {
            foreach (MonoBehaviour behaviour in Behaviours.ToArray())
                behaviour.GetType().GetMethod(message, BindingFlags.Instance | BindingFlags.NonPublic)?.Invoke(behaviour, new object[] { value });
        }

        public static void CallAll(string message)
        {
            for (int index = 0; index < Behaviours.Count; ++index)
            {
                if (Behaviours[index].IsRunning)
                    Call(Behaviours[index], message);
            }
        }

        /// <summary>Leaves play mode: destroys all objects of the scenes.</summary>
        public static void Stop()
        {
            foreach (Scene scene in SceneManager.Loaded.ToArray())
            {
                foreach (GameObject root in scene.Content.Roots.ToArray())
                    Object.DestroyImmediate(root);
            }
            foreach (GameObject root in SceneManager.Lasting.Content.Roots.ToArray())
                Object.DestroyImmediate(root);
            Destroyed.Clear();
            Messages.Clear();
            SceneManager.Reset();
            Time.timeScale = 1;
        }

        /// <summary>Enters play mode: calls this assembly's methods with RuntimeInitializeOnLoadMethod.</summary>
        public static void Begin(Assembly assembly)
        {
            foreach (Type type in assembly.GetTypes())
            {
                foreach (MethodInfo method in type.GetMethods(BindingFlags.Static | BindingFlags.NonPublic | BindingFlags.Public))
                {
                    if (method.GetCustomAttribute<RuntimeInitializeOnLoadMethodAttribute>() != null)
                        method.Invoke(null, null);
                }
            }
        }

        internal static void Add(MonoBehaviour behaviour)
        {
            int order = OrderOf(behaviour);
            int at = Behaviours.FindLastIndex(other => OrderOf(other) <= order) + 1;
            Behaviours.Insert(at, behaviour);
            Call(behaviour, "Awake");
            Sync(behaviour);
        }

        internal static void Sync(Behaviour behaviour)
        {
            if (!(behaviour is MonoBehaviour script) || script.IsRunning == script.isActiveAndEnabled || !Behaviours.Contains(script))
                return;
            script.IsRunning = script.isActiveAndEnabled;
            Call(script, script.IsRunning ? "OnEnable" : "OnDisable");
        }

        internal static void Stop(MonoBehaviour behaviour)
        {
            if (behaviour.IsRunning)
                Call(behaviour, "OnDisable");
            behaviour.IsRunning = false;
        }

        internal static void Call(Object receiver, string message)
        {
            if (!Messages.TryGetValue((receiver, message), out Action call))
            {
                MethodInfo method = receiver.GetType().GetMethod(
                    message, BindingFlags.Instance | BindingFlags.NonPublic | BindingFlags.Public, null, Type.EmptyTypes, null);
                call = method == null ? null : (Action)method.CreateDelegate(typeof(Action), receiver);
                Messages.Add((receiver, message), call);
            }
            call?.Invoke();
        }

        private static void Start(MonoBehaviour behaviour)
        {
            if (!behaviour.IsRunning || behaviour.HasStarted)
                return;
            behaviour.HasStarted = true;
            Call(behaviour, "Start");
        }

        private static int OrderOf(MonoBehaviour behaviour) => behaviour.GetType().GetCustomAttribute<DefaultExecutionOrder>()?.order ?? 0;
    }
}
