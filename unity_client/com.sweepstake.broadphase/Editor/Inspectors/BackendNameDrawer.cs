#nullable enable
using System.Collections.Generic;
using Sweepstake.Unity;
using UnityEditor;
using UnityEditor.UIElements;
using UnityEngine.UIElements;

namespace Sweepstake.Editor
{
    /// <summary>A text field with a drop-down of the library's backends that fills it; without the library, only the text field.</summary>
    [CustomPropertyDrawer(typeof(BackendNameAttribute))]
    internal sealed class BackendNameDrawer : PropertyDrawer
    {
        public override VisualElement CreatePropertyGUI(SerializedProperty property)
        {
            var text = new TextField(property.displayName) { tooltip = property.tooltip };
            text.AddToClassList("sweepstake-choice-text");
            text.BindProperty(property);
            var row = new VisualElement();
            PackagePaths.AddStyle(row);
            row.AddToClassList("sweepstake-choice");
            row.Add(text);
            if (SweepstakeLibrary.FindProblem() == null)
                row.Add(ChoiceFor(text));
            return row;
        }

        private DropdownField ChoiceFor(TextField text)
        {
            var choice = new DropdownField { choices = new List<string>(SweepstakeLibrary.Backends), tooltip = "The backends of the library." };
            choice.AddToClassList("sweepstake-choice-names");
            choice.RegisterValueChangedCallback(change =>
            {
                if (string.IsNullOrEmpty(change.newValue))
                    return;
                text.value = change.newValue;
                // Clear the selection, so that each name can be selected again.
                choice.SetValueWithoutNotify("");
            });
            return choice;
        }
    }
}
