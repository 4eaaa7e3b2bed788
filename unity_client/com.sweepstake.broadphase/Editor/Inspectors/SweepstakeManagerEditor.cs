#nullable enable
using System;
using System.Collections.Generic;
using System.IO;
using System.Text;
using Sweepstake.Unity;
using UnityEditor;
using UnityEditor.UIElements;
using UnityEngine.UIElements;

namespace Sweepstake.Editor
{
    /// <summary>Shows the fields as Unity draws them (undo, prefab overrides, multi-object editing); in play mode also state and actions.</summary>
    [CustomEditor(typeof(SweepstakeManager))]
    [CanEditMultipleObjects]
    internal sealed class SweepstakeManagerEditor : UnityEditor.Editor
    {
        private const long RefreshMs = 200;

        private readonly StringBuilder text = new StringBuilder();
        private StatusChip chip = null!;
        private Label decision = null!;
        private HelpBox problem = null!;
        private VisualElement live = null!;
        private DropdownField backend = null!;
        private Button connection = null!;

        public override VisualElement CreateInspectorGUI()
        {
            var root = new VisualElement();
            PackagePaths.AddStyle(root);
            chip = new StatusChip();
            root.Add(chip);
            problem = new HelpBox("", HelpBoxMessageType.Error);
            root.Add(problem);
            InspectorElement.FillDefaultInspector(root, serializedObject, this);
            root.Add(MakeLive());
            root.Add(new Button(SweepstakeWindow.Open) { text = "Live Window", tooltip = "Charts of frame rate, detection time and pairs, and the daemon's posteriors." });
            root.schedule.Execute(Refresh).Every(RefreshMs);
            Refresh();
            return root;
        }

        private VisualElement MakeLive()
        {
            live = new VisualElement();
            backend = new DropdownField("Backend now", new List<string>(), -1) { tooltip = "Selects a backend from the next frame on. In AI Decides the decider may switch again." };
            backend.RegisterValueChangedCallback(changed => Select(changed.newValue));
            decision = new Label();
            decision.AddToClassList("sweepstake-text");
            connection = new Button(ToggleConnection);
            var export = new Button(Export) { text = "Export Priors…", tooltip = "Saves what the game has learnt, for the config's 'Priors' or for `sweepstake priors import`." };
            foreach (VisualElement part in new VisualElement[] { backend, decision, connection, export })
                live.Add(part);
            return live;
        }

        private SweepstakeManager Manager => (SweepstakeManager)target;

        private void Refresh()
        {
            if (target == null)
                return;
            bool isLive = !serializedObject.isEditingMultipleObjects && Manager.Session != null;
            chip.Show(Manager.State);
            problem.text = Manager.Problem;
            problem.style.display = Manager.Problem.Length > 0 ? DisplayStyle.Flex : DisplayStyle.None;
            live.style.display = isLive ? DisplayStyle.Flex : DisplayStyle.None;
            if (isLive)
                RefreshLive();
        }

        private void RefreshLive()
        {
            backend.choices = new List<string>(Manager.Backends);
            backend.SetValueWithoutNotify(Manager.ActiveBackend);
            text.Clear();
            StatusText.AppendDecision(text, Manager);
            text.Append('\n').Append(Advice.Of(Manager.Verdict.Kind));
            decision.text = text.ToString();
            connection.text = Manager.Connection == null ? "Connect" : "Disconnect";
            connection.tooltip = Manager.Connection == null
                ? "Connects to the config's daemon, which then decides. From then on the game sends it measurements."
                : "Ends the connection. The game decides itself again and sends nothing more.";
        }

        private void Select(string name)
        {
            if (Manager.Session != null && !string.IsNullOrEmpty(name))
                Manager.SelectBackend(name);
        }

        private void ToggleConnection()
        {
            if (Manager.Connection == null)
                Manager.Connect();
            else
                Manager.Disconnect();
            Refresh();
        }

        private void Export()
        {
            if (Manager.Decider == null)
            {
                ShowMessage("A daemon stores what the game learns; export it with `sweepstake priors export`.");
                return;
            }
            try
            {
                Save(Manager.Decider.ExportPriors());
            }
            catch (Exception problem) when (problem is SweepstakeException || problem is IOException || problem is UnauthorizedAccessException)
            {
                ShowMessage("The priors were not exported. " + problem.Message);
            }
        }

        private static void Save(byte[] priors)
        {
            string path = EditorUtility.SaveFilePanel("Export priors", "Assets", "priors", "bytes");
            if (path.Length == 0)
                return;
            File.WriteAllBytes(path, priors);
            AssetDatabase.Refresh();
        }

        private static void ShowMessage(string problem) => EditorUtility.DisplayDialog("Sweepstake", problem, "OK");
    }
}
