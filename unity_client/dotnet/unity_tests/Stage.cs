using System;
using System.Collections.Generic;
using System.Reflection;
using NUnit.Framework;
using Sweepstake.LowLevel;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Tests
{
    /// <summary>Enters play mode before each test and leaves it afterwards, then checks that no native object is left.</summary>
    public abstract class Stage
    {
        private static readonly BindingFlags Fields = BindingFlags.Instance | BindingFlags.NonPublic | BindingFlags.Public;

        [SetUp]
        public void EnterPlayMode()
        {
            Debug.Lines.Clear();
            Application.persistentDataPath = System.IO.Directory.CreateTempSubdirectory("sweepstake").FullName;
            Player.Begin(typeof(Stage).Assembly);
        }

        [TearDown]
        public void LeavePlayMode()
        {
            Player.Stop();
            Application.isMobilePlatform = false;
            Application.isEditor = false;
            Application.streamingAssetsPath = "";
            Eventually.Is(IsDataDeleted, () => "deleted");
            Assert.That(SessionWork.RunningCount, Is.EqualTo(0), "no decider or connection is left");
            Assert.That(SweepstakeLibrary.LiveCount(), Is.EqualTo(0), "no native object is left");
        }

        /// <summary>Deletes the game's files. A decider that has ended may still be writing one; then the next try deletes it.</summary>
        private static bool IsDataDeleted()
        {
            try
            {
                System.IO.Directory.Delete(Application.persistentDataPath, true);
                return true;
            }
            catch (System.IO.IOException)
            {
                return !System.IO.Directory.Exists(Application.persistentDataPath);
            }
        }

        /// <summary>Creates a manager with short intervals.</summary>
        protected static SweepstakeManager MakeManager(Action<SweepstakeConfig> change = null, SessionMode mode = SessionMode.Ai, string backend = "")
        {
            var made = new GameObject("manager");
            made.SetActive(false);
            var manager = made.AddComponent<SweepstakeManager>();
            manager.Config = ScriptableObject.CreateInstance<SweepstakeConfig>();
            change?.Invoke(manager.Config);
            Set(manager, "mode", mode);
            Set(manager, "backend", backend);
            made.SetActive(true);
            return manager;
        }

        /// <summary>Sets a serialized field, as the inspector does.</summary>
        protected static void Set(object owner, string field, object value) => owner.GetType().GetField(field, Fields)!.SetValue(owner, value);

        /// <summary>Detaches the native decider, so that the thread of the managed one fails at its next poll.</summary>
        protected static void KillDecider(SweepstakeManager manager)
        {
            lock (typeof(SessionWork).GetProperty("Gate", Fields)!.GetValue(manager.Decider)!)
                Assert.That(NativeMethods.swp_session_detach_decider(manager.Session.Pointer), Is.EqualTo(ResultCode.Ok));
            FramesUntil(() => manager.Decider.Failure != null, "dead");
        }

        protected static void Frames(int count)
        {
            for (int frame = 0; frame < count; ++frame)
                Player.Frame();
        }

        protected static void FramesUntil(Func<bool> condition, string what) =>
            Eventually.Is(condition, () => what + "; " + string.Join("; ", Debug.Lines), () => Player.Frame());

        /// <summary>Plays a frame in which a key is pressed.</summary>
        protected static void Press(char key)
        {
            Input.Pressed = (KeyCode)char.ToLowerInvariant(key);
            Frames(1);
            Input.Pressed = KeyCode.None;
        }

        /// <summary>Presses the button whose text contains this part.</summary>
        protected static void Click(string part)
        {
            GUILayout.Pressed = part;
            Player.CallAll("OnGUI");
            GUILayout.Pressed = "";
        }

        /// <summary>The layers of static boxes: a static box is 16 layers above the one that a test names.</summary>
        protected static readonly LayerMask StaticLayers = unchecked((int)0xFFFF0000);

        protected static bool IsStatic(Collider collider) => collider.gameObject.layer >= 16;

        protected static BoxCollider MakeBox(Vector3 position, int layer = 0, bool isStatic = false, Transform parent = null)
        {
            var made = new GameObject("box") { layer = isStatic ? layer + 16 : layer };
            if (parent != null)
                made.transform.SetParent(parent, false);
            made.transform.position = position;
            var box = made.AddComponent<BoxCollider>();
            box.isTrigger = true;
            return box;
        }

        protected static long AllocatedBy(int frames) => Eventually.AllocatedBy(() => Frames(frames));

        protected static IEnumerable<string> Logged(string part) => Debug.Lines.FindAll(line => line.Contains(part));
    }
}
